"""The trapezoid rule, twice: AN3397 and the mbed tutorial."""

from __future__ import annotations

from dead_reckoning.core.integration.open_loop import OpenLoop
from dead_reckoning.core.samples import Vector


class Trapezoid(OpenLoop):
    """Take acceleration and velocity for linear between samples.

    ``v_k = v_{k−1} + ½ (a_{k−1} + a_k) Δt``, ``p_k = p_{k−1} + ½ (v_{k−1} + v_k) Δt``: the error
    over a fixed time falls with Δt².
    """

    def _integrate(self, dt: float, carried: Vector, before: Vector, accel_w: Vector) -> None:
        a, v, p, u = before, carried, self.position, self.velocity
        half = 0.5 * dt
        velocity = (
            v[0] + half * (a[0] + accel_w[0]),
            v[1] + half * (a[1] + accel_w[1]),
            v[2] + half * (a[2] + accel_w[2]),
        )
        self.position = (
            p[0] + half * (u[0] + velocity[0]),
            p[1] + half * (u[1] + velocity[1]),
            p[2] + half * (u[2] + velocity[2]),
        )
        self.velocity = velocity
