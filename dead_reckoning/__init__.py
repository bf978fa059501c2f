"""Position, velocity and steps from an inertial sensor, on ROS 2.

This page holds the conventions; every module keeps to them, and docs/conventions.md derives what
follows from them.

Units
    SI and radians everywhere inside; a unit stands in a name only where it is not SI (`range_g`).
    Time is an integer of nanoseconds, ``stamp_ns``; steps of time come from stamps, never from a
    clock.

Frames
    ``w``  world (`odom`): east, north, up; z up; continuous.
    ``b``  body (`base_link`): x forward, y left, z up (REP-103).
    ``s``  sensor (`imu_link`).

    A vector carries its frame as a suffix, ``force_s``; ``rot_ws`` takes s into w:
    ``force_w = rot_ws · force_s``.  Quaternions are (x, y, z, w), unit length, as in
    geometry_msgs.  Covariances of an attitude are about the axes of the world.

Words
    *specific force*       what an accelerometer measures: gravity in it, +g on the up axis at
                           rest.
    *linear acceleration*  the specific force with gravity taken off, in the world.
    *rest*, *stationary*   the device does not move; *movement-end check* is how AN3397 finds out.
    *offset*               what a sensor reads at zero g, against what it should read.

Values
    Samples and states are frozen dataclasses with tuples of floats
    (`dead_reckoning.core.samples`); settings are frozen dataclasses that are valid once they
    exist (`dead_reckoning.core.parameters`); errors have one root
    (`dead_reckoning.core.errors`).  A covariance of zeros is unknown, one whose first element
    is −1 says that the quantity is not measured (REP-145).

Rooms
    ``core``     samples, settings, models, estimators, the chain that composes them; no ROS,
                 clock, file or log.
    ``sources``  where samples come from: simulated sensors, serial ports, recordings.
    ``configuration``  all parts' settings, and the YAML files that hold them.
    ``nodes``    thin ROS 2 nodes around a chain.
    ``tools``    the command line; needs no ROS.
"""
