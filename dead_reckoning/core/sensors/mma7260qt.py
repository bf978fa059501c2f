"""Freescale MMA7260QT: three axes, analogue, ratiometric, ±1.5 to ±6 g (data sheet Rev 5).

Range, sensitivity, supply and the low-pass being of one pole are the sheet's; its corner,
tolerance, noise, drifts and swing are commonly stated figures.  The sheet's 4.7 mV rms of noise
and its 350 µg/√Hz disagree, so noise is a parameter.
"""

from __future__ import annotations

from dead_reckoning.core.sensors import Part

PART = Part(
    ranges={1.5: 0.8, 2.0: 0.6, 4.0: 0.3, 6.0: 0.2},
    supply=(3.3, 2.2, 3.6),
    ratiometric=True,
    zero_g=1.65,
    zero_g_tolerance=0.165,
    swing_margin=0.25,
    noise=0.0047,
    low_pass=(350.0, 350.0, 150.0),
    offset_drift=0.002,
    sensitivity_drift=0.0003,
    wake_time=0.0005,
)
