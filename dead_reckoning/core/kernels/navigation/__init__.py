"""Kernels of the inertial navigator; docs/navigation.md derives them.

``layout``       where things are in the arrays.
``strapdown``    carry state and errors over one sample.
``measurement``  take a measurement into state and covariance.
``rest``         what is known at rest: velocity, rate, floor.
``aiding``       what else is known: yaw, level, bounded velocity, wheels.
``filter``       the loop over samples.
``smoother``     the way back.
"""
