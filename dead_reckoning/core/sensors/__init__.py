"""What data sheets say of accelerometers: one module each, which offers ``PART``."""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module


@dataclass(frozen=True, kw_only=True)
class Part:
    """The figures of a data sheet, in the unit of the output: volts, or counts if digital.

    ``ranges``            range ± [g] → sensitivity at the nominal supply [unit/g].
    ``supply``            nominal, lowest and highest supply [V].
    ``ratiometric``       whether outputs are proportional to the supply.
    ``zero_g``            output at zero g and nominal supply [unit].
    ``zero_g_tolerance``  how far that may be off in a good part [unit].
    ``swing_margin``      how close to the rails the output swings [unit].
    ``noise``             of one conversion, one sigma [unit].
    ``low_pass``          corner of the one-pole low-pass of x, y, z [Hz]; zero for none.
    ``digital``           whether the output is a count; an ADC follows where it is not.
    ``offset_drift``      [g/K], ``sensitivity_drift`` [1/K].
    ``wake_time``         from sleep to a settled output [s].
    """

    ranges: Mapping[float, float]
    supply: tuple[float, float, float]
    ratiometric: bool
    zero_g: float
    zero_g_tolerance: float
    swing_margin: float
    noise: float
    low_pass: tuple[float, float, float]
    digital: bool = False
    offset_drift: float
    sensitivity_drift: float
    wake_time: float

    def limits(self, range_g: float) -> tuple[float, float]:
        """Return the lowest and the highest count of a digital output in a range.

        They span the range and no more, so in full resolution a smaller range has fewer bits.
        """
        half = round(range_g * self.ranges[range_g])
        return float(-half), float(half - 1)

    def scale(self, supply: float) -> float:
        """Return how the outputs scale with the supply [V]."""
        return supply / self.supply[0] if self.ratiometric else 1.0


def names() -> tuple[str, ...]:
    """List the sensors there are."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def part(name: str) -> Part:
    """Return the data sheet of a sensor by its name."""
    found: Part = import_module(f'{__name__}.{name}').PART
    return found
