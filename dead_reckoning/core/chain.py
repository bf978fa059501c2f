"""Compose estimators: samples in, named outputs out.

Names are the relative topic names of the design (``imu/data_raw``, ``odom``, …), so a single node
is a chain of one stage, ``pipeline`` and ``replay`` are whole chains, and all of them give the
same numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeAlias

from dead_reckoning.core.errors import DeadReckoningError

Output: TypeAlias = tuple[str, Any]
Stage: TypeAlias = Mapping[str, Callable[[Any], Iterable[Output]]]
"""What a stage does with each of its inputs: name → function from a sample to named outputs."""

FAULT = 'fault'
"""Name of the output that carries a `DeadReckoningError` instead of a sample."""

NOTICE = 'notice'
"""Name of the output that carries a sentence for the user."""

END = 'end'
"""Name of the input under which a stage that holds something back learns that no more comes."""


class Chain:
    """Run stages one after the other; what one puts out, those who ask for it by name take in.

    A stage that raises a `DeadReckoningError` loses that sample and no other; the error comes out
    under the name `FAULT`, and the other stages go on.
    """

    def __init__(self, stages: Iterable[Stage]) -> None:
        self._takers: dict[str, list[Callable[[Any], Iterable[Output]]]] = {}
        for stage in stages:
            for name, take in stage.items():
                self._takers.setdefault(name, []).append(take)

    def push(self, name: str, sample: Any) -> list[Output]:
        """Put one sample in under its name; return all outputs it caused, in order."""
        flow: list[Output] = [(name, sample)]
        for given, value in flow:  # grows while it is walked
            for take in self._takers.get(given, ()):
                try:
                    flow.extend(take(value))
                except DeadReckoningError as error:
                    flow.append((FAULT, error))
        del flow[0]
        return flow

    def end(self) -> list[Output]:
        """Say that no more samples come; return what the stages had held back."""
        return self.push(END, None)
