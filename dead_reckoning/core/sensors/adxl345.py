"""Analog Devices ADXL345 (data sheet Rev E), as in the mbed page: digital, ±2 to ±16 g.

In full resolution a count is 3.9 mg (256 counts/g) in every range, 13 bits at ±16 g.  Noise is
about one count rms on x and y at 100 Hz.
"""

from __future__ import annotations

from dead_reckoning.core.sensors import Part

PART = Part(
    ranges={2.0: 256.0, 4.0: 256.0, 8.0: 256.0, 16.0: 256.0},
    supply=(2.5, 2.0, 3.6),
    ratiometric=False,
    zero_g=0.0,
    zero_g_tolerance=64.0,
    swing_margin=0.0,
    noise=1.0,
    low_pass=(0.0, 0.0, 0.0),
    bits=13,
    offset_drift=0.0004,
    sensitivity_drift=0.0001,
    wake_time=0.0014,
)
