"""Analog Devices ADXL330 (data sheet Rev A), as in AN-900: analogue, ratiometric, ±3 g.

The bandwidth is set by capacitors; 30 Hz is what AN-900's 30 samples a second ask for.  The noise
is 280 µg/√Hz over that bandwidth of one pole: 280e-6 · √(1.57 · 30) g · 0.3 V/g.
"""

from __future__ import annotations

from dead_reckoning.core.sensors import Part

PART = Part(
    ranges={3.0: 0.3},
    supply=(3.0, 1.8, 3.6),
    ratiometric=True,
    zero_g=1.5,
    zero_g_tolerance=0.3,
    swing_margin=0.1,
    noise=0.00058,
    low_pass=(30.0, 30.0, 30.0),
    offset_drift=0.001,
    sensitivity_drift=0.00015,
    wake_time=0.03,
)
