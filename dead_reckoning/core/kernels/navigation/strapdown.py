"""Carry position, velocity and attitude over one sample, and their errors with them.

Derived in docs/navigation.md.  Errors are δp; ξ = exp(−θ) v − v̂, of the velocity along the axes
of the body; θ, R = exp(θ) R̂, about the axes of the world; of the biases of gyro and
accelerometer; and of the height of the floor.
"""

from __future__ import annotations

from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.rotation import (
    composed,
    matrix_from_quaternion,
    quaternion_from_turn,
    rotate,
    unit,
)
from dead_reckoning.core.samples import Matrix, Quaternion, Vector

UNEVEN = 0.2
"""A step before that is shorter than this part of one says nothing about the curvature."""


def added(a: Vector, b: Vector, scale: float) -> Vector:
    """Return a + scale · b."""
    return a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def integral(
    dt: float, dt0: float, y2: Vector, y1: Vector, y0: Vector, averaging: float
) -> Vector:
    """Integrate over the last step the parabola that shows three values, the last one first.

    ``dt`` and ``dt0`` are the steps [s] after and before the middle one, ``y1``; with no or a far
    shorter one before it is a straight line.  Values are means over ``averaging`` · dt.
    """
    line = added(added((0.0, 0.0, 0.0), y1, 0.5 * dt), y2, 0.5 * dt)
    if dt0 <= UNEVEN * dt:
        return line
    share = (1.0 + 0.5 * averaging * averaging) * dt * dt * dt / (6.0 * (dt + dt0))
    bend = added(added(y2, y1, -1.0), added(y1, y0, -1.0), -dt / dt0)
    return added(line, bend, -share / dt)


def increments(
    dt: float, turn: Vector, push: Vector, w1: Vector, w2: Vector, f1: Vector, f2: Vector
) -> tuple[Vector, Vector]:
    """Return rotation vector [rad] and change of velocity [m/s], in the axes before the step.

    ``turn`` and ``push`` are the integrals of rate and force, ``w1``, ``f1`` and ``w2``, ``f2``
    their values before and after.  Coning and sculling of a rate and a force that are linear:
    P. G. Savage, *Strapdown inertial navigation integration algorithm design*, J. Guid. Control
    Dyn. 21, 1998, doi:10.2514/2.4228 and doi:10.2514/2.4242.
    """
    part = dt * dt / 12.0
    rotation = added(turn, cross(w1, w2), part)
    sculling = added(cross(w1, f2), cross(f1, w2), 1.0)
    once = cross(turn, push)
    turned = added(added(push, once, 0.5), cross(turn, once), 1.0 / 6.0)
    return rotation, added(turned, sculling, part)


def moved(
    dt: float,
    gravity: float,
    velocity: Vector,
    attitude: Quaternion,
    rotation: Vector,
    push: Vector,
) -> tuple[Vector, Vector, Quaternion, Matrix]:
    """Return step of the position, velocity, attitude, and the matrix of the attitude before."""
    rot_ws = matrix_from_quaternion(attitude)
    x, y, z = added(velocity, rotate(rot_ws, push), 1.0)
    after = (x, y, z - gravity * dt)
    way = added(added((0.0, 0.0, 0.0), velocity, 0.5 * dt), after, 0.5 * dt)
    return way, after, unit(composed(attitude, quaternion_from_turn(rotation))), rot_ws


def carry(m: Array, dt: float, gravity: float, rot: Matrix, way: Vector, v: Vector) -> None:
    """Multiply F · m in place, m of shape (16, n).

    δp ← δp + Δt ξ − way × θ + ½ Δt² (g × θ − R δb_a),  ξ ← ξ + Δt g × θ − v × (Δt R δb_g)
    − Δt R δb_a,  θ ← θ − Δt R δb_g,  with the velocity v after the step and the matrix R before
    it.  At rest a tilt and a bias that hide each other leave the position alone, too.
    """
    h, g = 0.5 * dt, gravity * dt
    r00, r01, r02 = dt * rot[0], dt * rot[1], dt * rot[2]
    r10, r11, r12 = dt * rot[3], dt * rot[4], dt * rot[5]
    r20, r21, r22 = dt * rot[6], dt * rot[7], dt * rot[8]
    cx, cy, cz = way
    vx, vy, vz = v
    for j in range(m.shape[1]):
        tx, ty, tz = m[6, j], m[7, j], m[8, j]
        x, y, z = m[9, j], m[10, j], m[11, j]
        bx, by, bz = (
            r00 * x + r01 * y + r02 * z,
            r10 * x + r11 * y + r12 * z,
            r20 * x + r21 * y + r22 * z,
        )
        x, y, z = m[12, j], m[13, j], m[14, j]
        ax, ay, az = (
            r00 * x + r01 * y + r02 * z,
            r10 * x + r11 * y + r12 * z,
            r20 * x + r21 * y + r22 * z,
        )
        m[0, j] += dt * m[3, j] - (cy * tz - cz * ty) + h * (g * ty - ax)
        m[1, j] += dt * m[4, j] - (cz * tx - cx * tz) - h * (g * tx + ay)
        m[2, j] += dt * m[5, j] - (cx * ty - cy * tx) - h * az
        m[3, j] += g * ty - (vy * bz - vz * by) - ax
        m[4, j] += -g * tx - (vz * bx - vx * bz) - ay
        m[5, j] += -(vx * by - vy * bx) - az
        m[6, j], m[7, j], m[8, j] = tx - bx, ty - by, tz - bz


def carry_back(m: Array, dt: float, gravity: float, rot: Matrix, way: Vector, v: Vector) -> None:
    """Multiply Fᵀ · m in place, F of `carry`."""
    h, g = 0.5 * dt, gravity * dt
    cx, cy, cz = way
    vx, vy, vz = v
    for j in range(m.shape[1]):
        px, py, pz = m[0, j], m[1, j], m[2, j]
        x, y, z = m[3, j], m[4, j], m[5, j]
        sx, sy, sz = (
            m[6, j] + y * vz - z * vy,
            m[7, j] + z * vx - x * vz,
            m[8, j] + x * vy - y * vx,
        )
        ux, uy, uz = x + h * px, y + h * py, z + h * pz
        m[3, j], m[4, j], m[5, j] = x + dt * px, y + dt * py, z + dt * pz
        m[6, j] += cy * pz - cz * py - g * uy
        m[7, j] += cz * px - cx * pz + g * ux
        m[8, j] += cx * py - cy * px
        m[9, j] -= dt * (rot[0] * sx + rot[3] * sy + rot[6] * sz)
        m[10, j] -= dt * (rot[1] * sx + rot[4] * sy + rot[7] * sz)
        m[11, j] -= dt * (rot[2] * sx + rot[5] * sy + rot[8] * sz)
        m[12, j] -= dt * (rot[0] * ux + rot[3] * uy + rot[6] * uz)
        m[13, j] -= dt * (rot[1] * ux + rot[4] * uy + rot[7] * uz)
        m[14, j] -= dt * (rot[2] * ux + rot[5] * uy + rot[8] * uz)


def transpose(m: Array) -> None:
    """Transpose a square matrix in place."""
    for i in range(len(m)):
        for j in range(i):
            m[i, j], m[j, i] = m[j, i], m[i, j]


def mirror(m: Array) -> None:
    """Make a square matrix symmetric, by its upper triangle."""
    for i in range(len(m)):
        for j in range(i):
            m[i, j] = m[j, i]


def spread(p: Array, v: Vector, velocity: float, rate: float) -> None:
    """Add the noise of a step to the upper triangle of a covariance.

    ``velocity`` [m²/s²] and ``rate`` [rad²] are the variances that it gives velocity and attitude;
    the latter reaches ξ through the velocity: Σ_ξξ += q (|v|² I − v vᵀ), Σ_ξθ += q [v]×.
    """
    x, y, z = v
    for i in range(3):
        p[3 + i, 3 + i] += velocity + rate * (x * x + y * y + z * z)
        p[6 + i, 6 + i] += rate
    p[3, 3] -= rate * x * x
    p[3, 4] -= rate * x * y
    p[3, 5] -= rate * x * z
    p[4, 4] -= rate * y * y
    p[4, 5] -= rate * y * z
    p[5, 5] -= rate * z * z
    p[3, 7] -= rate * z
    p[3, 8] += rate * y
    p[4, 6] += rate * z
    p[4, 8] -= rate * x
    p[5, 6] -= rate * y
    p[5, 7] += rate * x
