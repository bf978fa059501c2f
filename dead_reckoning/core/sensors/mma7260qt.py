"""Freescale MMA7260QT, three axes, analogue, ±1.5 to ±6 g (data sheet Rev 5)."""

from __future__ import annotations

SENSITIVITY = {1.5: 0.8, 2.0: 0.6, 4.0: 0.3, 6.0: 0.2}
"""g-select range [g] → typical sensitivity at the nominal supply [V/g]."""

NOMINAL_SUPPLY = 3.3
"""Supply of the data sheet [V]; the outputs are ratiometric to the supply."""

SUPPLY = (2.2, 3.6)
"""Range of the supply [V]."""

ZERO_G_TOLERANCE = 0.165
"""How far the zero-g output may be off at the nominal supply [V]."""

SWING_MARGIN = 0.25
"""How close to the rails the output swings [V]."""

NOISE = 0.0047
"""Noise over 0.1 Hz to 1 kHz, one sigma [V]; the sheet's 350 µg/√Hz disagrees: a parameter."""


def sensitivity(range_g: float, supply: float) -> float:
    """Return the typical sensitivity [V/g] for a range [g] at a supply [V]."""
    return SENSITIVITY[range_g] * supply / NOMINAL_SUPPLY


def zero_g_tolerance(supply: float) -> float:
    """Return how far the zero-g output may be off [V] at a supply [V]."""
    return ZERO_G_TOLERANCE * supply / NOMINAL_SUPPLY
