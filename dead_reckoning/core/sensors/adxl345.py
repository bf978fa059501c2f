"""Analog Devices ADXL345 (data sheet Rev E), as in the mbed page: digital, ±2 to ±16 g.

In full resolution a count is 3.9 mg (256 counts/g) in every range: 10 bits at ±2 g, 13 at ±16 g.
The noise, about one count rms, is that of up to 100 conversions a second; above, it grows with
the square root of their rate.  The digital low-pass at half the rate of conversions, and that the
lowest bit stays 0 at 1600 and 3200 Hz, are left out.
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
    digital=True,
    offset_drift=0.0004,
    sensitivity_drift=0.0001,
    wake_time=0.0014,
)
