"""How far a heading error that changes with the heading leads astray."""

from __future__ import annotations

from math import hypot

from dead_reckoning.core.samples import Matrix, Vector

MINIMUM_LEVEL = 0.1
"""Sine of the angle to the vertical from which on the axis points somewhere."""


class HeadingWander:
    """Carry the covariance of position that the changing part of a heading error brings.

    Iron near a compass bends headings by ``d(ψ) = α cos ψ + β sin ψ``, and so does a constant
    tilt: one way here and another there, so it does not cancel where the way closes, and the same
    on every round, so it grows with the way.  α and β are constants of one deviation.  Counted is
    ``d(ψ) − d(ψ₀)``, as the attitude's own covariance holds the error at the start.
    docs/integrator.md, "One axis along a heading".
    """

    def __init__(self, deviation: float, axis: int) -> None:
        """``deviation`` of d [rad]; ``axis`` of the sensor along which it moves, 0 to 2."""
        self._variance = deviation**2
        self._axis = axis
        self.reset()

    def reset(self) -> None:
        """Begin at a position and with a heading error that are known."""
        self._start: tuple[float, float] | None = None
        self._cosine = self._sine = 0.0  # beyond those at the start
        self._alpha_x = self._alpha_y = self._beta_x = self._beta_y = 0.0  # of the position [m]

    def step(self, dt: float, rot_ws: Matrix, velocity_w: Vector) -> None:
        """Go on for ``dt`` [s] at a velocity, shape (3,) [m/s], world."""
        east, north = rot_ws[self._axis], rot_ws[3 + self._axis]
        level = hypot(east, north)
        if level > MINIMUM_LEVEL:
            cosine, sine = east / level, north / level
            self._start = self._start or (cosine, sine)
            self._cosine, self._sine = cosine - self._start[0], sine - self._start[1]
        x, y = -velocity_w[1] * dt, velocity_w[0] * dt  # across the way
        self._alpha_x += self._cosine * x
        self._alpha_y += self._cosine * y
        self._beta_x += self._sine * x
        self._beta_y += self._sine * y

    def added(
        self, position: Matrix, velocity: Matrix, velocity_w: Vector
    ) -> tuple[Matrix, Matrix]:
        """Return covariances of position and velocity, shapes (3, 3), with this added to them."""
        s, x, y = self._variance, -velocity_w[1], velocity_w[0]
        dd = s * (self._cosine**2 + self._sine**2)
        ax, ay, bx, by = self._alpha_x, self._alpha_y, self._beta_x, self._beta_y
        return (
            _plus(position, s * (ax * ax + bx * bx), s * (ax * ay + bx * by), s * (ay**2 + by**2)),
            _plus(velocity, x * x * dd, x * y * dd, y * y * dd),
        )


def _plus(matrix: Matrix, xx: float, xy: float, yy: float) -> Matrix:
    a, b, c, d, e, f, g, h, i = matrix
    return (a + xx, b + xy, c, d + xy, e + yy, f, g, h, i)
