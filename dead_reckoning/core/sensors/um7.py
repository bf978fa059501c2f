"""CH Robotics UM7 (data sheet Rev 1.6): digital, an orientation sensor that sends g, not counts.

A count stands for what its 16-bit converter at ±8 g resolves, 1/4096 g.  None of these figures is
confirmed: range, offset, drifts and wake time are those commonly stated of its inertial chip, the
MPU-9250, and so is the supply, which a regulator on the board makes of 5 V.  The noise, 4 mg, is
what the public ROS driver states from a device at rest.
"""

from __future__ import annotations

from dead_reckoning.core.sensors import Part

PART = Part(
    ranges={8.0: 4096.0},
    supply=(3.3, 2.4, 3.6),
    ratiometric=False,
    zero_g=0.0,
    zero_g_tolerance=328.0,
    swing_margin=0.0,
    noise=16.4,
    low_pass=(0.0, 0.0, 0.0),
    digital=True,
    offset_drift=0.0015,
    sensitivity_drift=0.00026,
    wake_time=0.03,
)
