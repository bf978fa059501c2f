"""Run stages over blocks of samples: the same outputs, in columns."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from dead_reckoning.core.blocks import BLOCKS, Stamped
from dead_reckoning.core.chain import FAULT, Output, Stage
from dead_reckoning.core.errors import DeadReckoningError


def blockwise(stage: Stage) -> Stage:
    """Return a stage that takes and gives blocks, and runs another one sample by sample.

    Outputs of one name come as one block where they are samples, and as `Stamped` values where
    they are not, as faults and notices; each name's are in order.
    """
    return {name: partial(_take, take) for name, take in stage.items()}


def _take(take: Callable[[Any], Iterable[Output]], block: Any) -> list[Output]:
    samples: dict[str, list[Any]] = {}
    outputs: list[Output] = []
    for index in range(len(block)):
        sample = block.sample(index)
        try:
            made = take(sample)
        except DeadReckoningError as error:
            made = [(FAULT, error)]
        for name, value in made:
            if type(value) in BLOCKS:
                samples.setdefault(name, []).append(value)
            else:
                outputs.append((name, Stamped(int(block.stamp_ns[index]), value)))
    for name, values in samples.items():
        outputs.append((name, BLOCKS[type(values[0])].of(values)))
    return outputs
