"""How far a heading error that changes with the heading leads astray."""

from __future__ import annotations

from math import acos, exp

from dead_reckoning.core.samples import Matrix, Vector

TURN = 0.2
"""How far the body turns before its heading error counts as another [rad]."""


class HeadingWander:
    """Carry the covariance of position that the changing part of a heading error brings.

    Iron near a compass bends headings by d(ψ), one way here and another there, so it does not
    cancel where the way closes, as a constant error does.  d is a Gauss-Markov process over the
    angle turned, correlated over 1 rad; it begins at zero, as the attitude's own covariance holds
    the error at the start.  docs/integrator.md, "One axis along a heading".
    """

    def __init__(self, deviation: float, axis: int) -> None:
        """``deviation`` of d [rad]; ``axis`` of the sensor along which it moves, 0 to 2."""
        self._variance = deviation**2
        self._axis = axis
        self.reset()

    def reset(self) -> None:
        """Begin at a position and with a heading error that are known."""
        self._anchor: Vector | None = None
        self._dd = self._xd = self._yd = self._xx = self._xy = self._yy = 0.0

    def step(self, dt: float, rot_ws: Matrix, velocity_w: Vector) -> None:
        """Go on for ``dt`` [s] at a velocity, shape (3,) [m/s], world."""
        ahead = (rot_ws[self._axis], rot_ws[3 + self._axis], rot_ws[6 + self._axis])
        before = self._anchor or ahead
        along = sum(a * b for a, b in zip(before, ahead, strict=True))
        angle = acos(max(-1.0, min(1.0, along)))
        if angle > TURN:
            kept = exp(-angle)
            self._dd = kept * kept * self._dd + (1.0 - kept * kept) * self._variance
            self._xd *= kept
            self._yd *= kept
            before = ahead
        self._anchor = before
        x, y = -velocity_w[1] * dt, velocity_w[0] * dt  # across the way
        self._xx += x * (2.0 * self._xd + x * self._dd)
        self._xy += x * self._yd + y * self._xd + x * y * self._dd
        self._yy += y * (2.0 * self._yd + y * self._dd)
        self._xd += x * self._dd
        self._yd += y * self._dd

    def added(
        self, position: Matrix, velocity: Matrix, velocity_w: Vector
    ) -> tuple[Matrix, Matrix]:
        """Return covariances of position and velocity, shapes (3, 3), with this added to them."""
        x, y = -velocity_w[1], velocity_w[0]
        return (
            _plus(position, self._xx, self._xy, self._yy),
            _plus(velocity, x * x * self._dd, x * y * self._dd, y * y * self._dd),
        )


def _plus(matrix: Matrix, xx: float, xy: float, yy: float) -> Matrix:
    a, b, c, d, e, f, g, h, i = matrix
    return (a + xx, b + xy, c, d + xy, e + yy, f, g, h, i)
