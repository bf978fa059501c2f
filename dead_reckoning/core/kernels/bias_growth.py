"""What `BiasGrowth` does, on arrays and in scalars: equations and derivation are there."""

from __future__ import annotations

from typing import NamedTuple

from dead_reckoning.core.bias_growth import FLOOR
from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import similarity
from dead_reckoning.core.samples import Matrix, Vector


class Growth(NamedTuple):
    """State and settings of a `BiasGrowth`.

    ``position``, ``velocity``   shapes (3, 7): their sensitivities to (θ, γ, b).
    ``attitude``          shape (9,) [rad²]: covariance of the attitude at the last step.
    ``gravity_variance``  shape (1,) [m²/s⁴]: that of γ at the last step.
    ``offset_variance``   shape (1,) [m²/s⁴].
    ``white``             shape (3,): variances pp, pv, vv of white noise.
    ``moves``             shape (3,): 1 for the axes of the sensor along which the body moves.
    ``jacobian``          shape (3, 7): room for that of one step.
    """

    position: Array
    velocity: Array
    attitude: Array
    gravity_variance: Array
    offset_variance: Array
    white: Array
    moves: Array
    jacobian: Array


def grow(
    growth: Growth,
    dt: float,
    rot_ws: Matrix,
    force_w: Vector,
    attitude: Matrix,
    noise: Matrix,
    gravity_variance: float,
) -> None:
    """Grow over one sample: `BiasGrowth.step`."""
    position, velocity, jacobian = growth.position, growth.velocity, growth.jacobian
    white, known = growth.white, growth.attitude
    known[0], known[1], known[2], known[3], known[4], known[5], known[6], known[7], known[8] = (
        attitude
    )
    growth.gravity_variance[0] = gravity_variance
    _write_jacobian(jacobian, rot_ws, force_w, growth.moves)
    for row in range(jacobian.shape[0]):
        for column in range(jacobian.shape[1]):
            j = jacobian[row, column]
            position[row, column] += dt * velocity[row, column] + (0.5 * dt * dt) * j
            velocity[row, column] += dt * j
    variance = (noise[0] + noise[4] + noise[8]) / 3.0
    white[0] += 2.0 * dt * white[1] + dt * dt * white[2]
    white[1] += dt * white[2]
    white[0] += 0.25 * variance * dt**4
    white[1] += 0.5 * variance * dt**3
    white[2] += variance * dt * dt


def stop(growth: Growth) -> None:
    """Take note that the velocity is known to be zero: `BiasGrowth.stop`."""
    velocity, white = growth.velocity, growth.white
    for row in range(velocity.shape[0]):
        for column in range(velocity.shape[1]):
            velocity[row, column] = 0.0
    white[1] = white[2] = 0.0


def stop_along(growth: Growth, axis_w: Vector) -> None:
    """Take note that the velocity along one axis is zero: `BiasGrowth.stop_along`."""
    x, y, z = axis_w
    velocity = growth.velocity
    for column in range(velocity.shape[1]):
        along = x * velocity[0, column] + y * velocity[1, column] + z * velocity[2, column]
        velocity[0, column] -= x * along
        velocity[1, column] -= y * along
        velocity[2, column] -= z * along


def covariance(sensitivity: Array, growth: Growth, white: float) -> Matrix:
    """Return the covariance, shape (3, 3), of what has a sensitivity, position or velocity.

    ``white`` is the variance of each axis that adds to it.
    """
    s, p = sensitivity, growth.attitude
    g, v = growth.gravity_variance[0], growth.offset_variance[0]
    xx, xy, xz, _, yy, yz, _, _, zz = similarity(
        (s[0, 0], s[0, 1], s[0, 2], s[1, 0], s[1, 1], s[1, 2], s[2, 0], s[2, 1], s[2, 2]),
        (p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8]),
    )
    oxx, oxy, oxz, _, oyy, oyz, _, _, ozz = similarity(
        (s[0, 4], s[0, 5], s[0, 6], s[1, 4], s[1, 5], s[1, 6], s[2, 4], s[2, 5], s[2, 6]),
        (v, 0.0, 0.0, 0.0, v, 0.0, 0.0, 0.0, v),
    )
    always = white + FLOOR
    x, y, z = s[0, 3], s[1, 3], s[2, 3]
    xx, xy, xz = xx + g * x * x + oxx + always, xy + g * x * y + oxy, xz + g * x * z + oxz
    yy, yz, zz = yy + g * y * y + oyy + always, yz + g * y * z + oyz, zz + g * z * z + ozz + always
    return xx, xy, xz, xy, yy, yz, xz, yz, zz


def _write_jacobian(out: Array, rot_ws: Matrix, force_w: Vector, moves: Array) -> None:
    """Write how θ, γ and b add to the acceleration: `acceleration_error.write_jacobian`."""
    x, y, z = force_w
    _write_cross(out, -x, -y, -z)
    a, b, c, d, e, f, g, h, i = rot_ws
    out[0, 3], out[1, 3], out[2, 3] = 0.0, 0.0, -1.0
    out[0, 4], out[0, 5], out[0, 6] = a, b, c
    out[1, 4], out[1, 5], out[1, 6] = d, e, f
    out[2, 4], out[2, 5], out[2, 6] = g, h, i
    if moves[0] + moves[1] + moves[2] == 3.0:
        return
    a, b, c, d, e, f, g, h, i = similarity(
        rot_ws, (moves[0], 0.0, 0.0, 0.0, moves[1], 0.0, 0.0, 0.0, moves[2])
    )
    z -= GRAVITY
    moved = a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z
    _write_cross(out, 0.0, 0.0, -GRAVITY)
    for column in range(out.shape[1]):
        x, y, z = out[0, column], out[1, column], out[2, column]
        out[0, column] = a * x + b * y + c * z
        out[1, column] = d * x + e * y + f * z
        out[2, column] = g * x + h * y + i * z
    x, y, z = moved
    out[0, 1] += z
    out[0, 2] -= y
    out[1, 0] -= z
    out[1, 2] += x
    out[2, 0] += y
    out[2, 1] -= x


def _write_cross(out: Array, x: float, y: float, z: float) -> None:
    out[0, 0] = out[1, 1] = out[2, 2] = 0.0
    out[0, 1], out[0, 2], out[1, 2] = -z, y, -x
    out[1, 0], out[2, 0], out[2, 1] = z, -y, x
