"""Euler's method, twice: CH Robotics, "Using Accelerometers", section 3."""

from __future__ import annotations

from dead_reckoning.core.integration.open_loop import OpenLoop
from dead_reckoning.core.samples import Vector


class Euler(OpenLoop):
    """Hold acceleration and velocity from sample to sample.

    ``v_k = v_{k−1} + a_{k−1} Δt``, ``p_k = p_{k−1} + v_{k−1} Δt``: the error over a fixed time
    falls with Δt.
    """

    def _integrate(self, dt: float, carried: Vector, before: Vector, accel_w: Vector) -> None:
        a, v, p, u = before, carried, self.position, self.velocity
        self.position = (p[0] + dt * u[0], p[1] + dt * u[1], p[2] + dt * u[2])
        self.velocity = (v[0] + dt * a[0], v[1] + dt * a[1], v[2] + dt * a[2])
