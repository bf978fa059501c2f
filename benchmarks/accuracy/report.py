"""What one recording showed: a table for people, figures for programs, a picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from dead_reckoning.tools.table import table


class Goal(NamedTuple):
    """What is to be reached, how much of it, what was found, and whether it will do.

    ``met`` is None where it cannot be told.
    """

    what: str
    wanted: str
    found: str
    met: bool | None


@dataclass
class Report:
    """What a benchmark found; ``faults`` say what must not be, and make the run fail."""

    name: str
    title: str
    text: list[str] = field(default_factory=list)
    figures: dict[str, Any] = field(default_factory=dict)
    pictures: list[Path] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    goals: list[Goal] = field(default_factory=list)

    def add_table(self, caption: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        """Add a table with a line above it that says what it holds."""
        self.text.append(f'{caption}\n{table(head, rows)}')

    def aim(self, what: str, found: float, most: float, form: str = '{:.2f}') -> None:
        """Add a goal: a figure, written by ``form``, that is to be at most so much."""
        self.goals.append(
            Goal(what, f'≤ {form.format(most)}', form.format(found), bool(found <= most))
        )

    def reach(self, what: str, found: float, least: float, form: str = '{:.2f}') -> None:
        """Add a goal: a figure, written by ``form``, that is to be at least so much."""
        self.goals.append(
            Goal(what, f'≥ {form.format(least)}', form.format(found), bool(found >= least))
        )
