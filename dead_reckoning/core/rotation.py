"""Rotate vectors, quaternions and covariances given as tuples.

``rot_wb`` takes b into w: ``v_w = rotate(rot_wb, v_b)``.  Quaternions are (x, y, z, w).  Derived
in docs/conventions.md, "Rotations".
"""

from __future__ import annotations

from math import atan2, cos, hypot, isfinite, sin, sqrt

from dead_reckoning.core.errors import NotFiniteError
from dead_reckoning.core.samples import Matrix, Quaternion, Vector

NO_ROTATION: Quaternion = (0.0, 0.0, 0.0, 0.0)


def matrix_from_quaternion(quaternion: Quaternion) -> Matrix:
    """Turn a unit quaternion (x, y, z, w) into its rotation matrix, shape (3, 3)."""
    x, y, z, w = quaternion
    xx, yy, zz = x * x, y * y, z * z
    xy, xz, yz = x * y, x * z, y * z
    wx, wy, wz = w * x, w * y, w * z
    return (
        1.0 - 2.0 * (yy + zz), 2.0 * (xy - wz), 2.0 * (xz + wy),
        2.0 * (xy + wz), 1.0 - 2.0 * (xx + zz), 2.0 * (yz - wx),
        2.0 * (xz - wy), 2.0 * (yz + wx), 1.0 - 2.0 * (xx + yy),
    )  # fmt: skip


def quaternion_from_euler(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Turn roll, pitch, yaw [rad], in this order about the fixed x, y, z, into (x, y, z, w)."""
    cr, sr = cos(roll / 2), sin(roll / 2)
    cp, sp = cos(pitch / 2), sin(pitch / 2)
    cy, sy = cos(yaw / 2), sin(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def euler_from_gravity(specific_force_s: Vector) -> tuple[float, float]:
    """Read roll and pitch [rad] off the specific force at rest, shape (3,), frame of the sensor.

    At rest ``f_s = rot_sw · (0, 0, g)``, which gives ``roll = atan2(f_y, f_z)`` and
    ``pitch = atan2(-f_x, √(f_y² + f_z²))``; yaw does not show.
    """
    fx, fy, fz = specific_force_s
    return atan2(fy, fz), atan2(-fx, hypot(fy, fz))


def yaw_from_quaternion(quaternion: Quaternion) -> float:
    """Read the yaw [rad] off a quaternion (x, y, z, w)."""
    x, y, z, w = quaternion
    return atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def composed(q_wa: Quaternion, q_ab: Quaternion) -> Quaternion:
    """Turn by ``q_ab``, then by ``q_wa``: return ``q_wb``."""
    ax, ay, az, aw = q_wa
    bx, by, bz, bw = q_ab
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def inverse(quaternion: Quaternion) -> Quaternion:
    """Turn back what a unit quaternion (x, y, z, w) turns."""
    x, y, z, w = quaternion
    return (-x, -y, -z, w)


def quaternion_from_turn(turn: Vector) -> Quaternion:
    """Turn a rotation vector, shape (3,) [rad], into its quaternion (x, y, z, w)."""
    x, y, z = turn
    angle = sqrt(x * x + y * y + z * z)
    # sin(½α)/α; below the limit its series is exact to rounding.
    scale = sin(0.5 * angle) / angle if angle > 1e-4 else 0.5 - angle * angle / 48.0
    return (scale * x, scale * y, scale * z, cos(0.5 * angle))


def normalized(quaternion: Quaternion) -> Quaternion:
    """Return a quaternion (x, y, z, w) at unit length: itself, if it is that long already.

    Raises `NotFiniteError` for one that is no rotation: not finite, or all but zero.
    """
    found = unit(quaternion)
    if found == NO_ROTATION:
        raise NotFiniteError(f'the orientation is {quaternion}, no rotation: check the driver')
    return found


def unit(quaternion: Quaternion) -> Quaternion:
    """Return a quaternion (x, y, z, w) at unit length, as `normalized`; zeros for no rotation."""
    x, y, z, w = quaternion
    square = x * x + y * y + z * z + w * w
    if abs(square - 1.0) < 1e-9:
        return quaternion
    if not isfinite(square) or square < 1e-6:
        return NO_ROTATION
    scale = 1.0 / sqrt(square)
    return (x * scale, y * scale, z * scale, w * scale)


def rotate(rot_wb: Matrix, vector_b: Vector) -> Vector:
    """Take a vector from b to w: ``rot_wb · v_b``."""
    a, b, c, d, e, f, g, h, i = rot_wb
    x, y, z = vector_b
    return (a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z)


def rotate_back(rot_wb: Matrix, vector_w: Vector) -> Vector:
    """Take a vector from w to b: ``rot_wbᵀ · v_w``."""
    a, b, c, d, e, f, g, h, i = rot_wb
    x, y, z = vector_w
    return (a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z)


def rotate_covariance(rot_wb: Matrix, covariance_b: Matrix) -> Matrix:
    """Take a covariance, shape (3, 3), from b to w: ``rot_wb · Σ_b · rot_wbᵀ``."""
    xx, xy, xz, _, yy, yz, _, _, zz = covariance_b
    if xx == yy == zz and xy == xz == yz == 0.0:
        return covariance_b  # a sphere looks the same from everywhere
    return similarity(rot_wb, covariance_b)


def cross_covariance(vector: Vector, covariance: Matrix) -> Matrix:
    """Say how well ``v × θ`` is known when θ, shape (3,), has Σ: ``[v]× · Σ · [v]×ᵀ``."""
    return similarity(cross_matrix(vector), covariance)


def transposed(m: Matrix) -> Matrix:
    """Return mᵀ; shape (3, 3)."""
    a, b, c, d, e, f, g, h, i = m
    return (a, d, g, b, e, h, c, f, i)


def product(m: Matrix, s: Matrix) -> Matrix:
    """Multiply out ``m · s``; shapes (3, 3)."""
    a, b, c, d, e, f, g, h, i = s
    return (
        m[0] * a + m[1] * d + m[2] * g, m[0] * b + m[1] * e + m[2] * h,
        m[0] * c + m[1] * f + m[2] * i,
        m[3] * a + m[4] * d + m[5] * g, m[3] * b + m[4] * e + m[5] * h,
        m[3] * c + m[4] * f + m[5] * i,
        m[6] * a + m[7] * d + m[8] * g, m[6] * b + m[7] * e + m[8] * h,
        m[6] * c + m[7] * f + m[8] * i,
    )  # fmt: skip


def cross_matrix(v: Vector) -> Matrix:
    """Return [v]×, which makes v × a of a vector a."""
    x, y, z = v
    return (0.0, -z, y, z, 0.0, -x, -y, x, 0.0)


def similarity(m: Matrix, s: Matrix) -> Matrix:
    """Multiply out ``m · s · mᵀ`` for a symmetric s; shapes (3, 3)."""
    xx, xy, xz, _, yy, yz, _, _, zz = s
    a, b, c, d, e, f, g, h, i = m
    ax, ay, az = a * xx + b * xy + c * xz, a * xy + b * yy + c * yz, a * xz + b * yz + c * zz
    dx, dy, dz = d * xx + e * xy + f * xz, d * xy + e * yy + f * yz, d * xz + e * yz + f * zz
    gx, gy, gz = g * xx + h * xy + i * xz, g * xy + h * yy + i * yz, g * xz + h * yz + i * zz
    ad = ax * d + ay * e + az * f
    ag = ax * g + ay * h + az * i
    dg = dx * g + dy * h + dz * i
    return (
        ax * a + ay * b + az * c, ad, ag,
        ad, dx * d + dy * e + dz * f, dg,
        ag, dg, gx * g + gy * h + gz * i,
    )  # fmt: skip


def variance_along(vector: Vector, covariance: Matrix) -> float:
    """Say how well ``v · a`` is known when a, shape (3,), has Σ: ``v · Σ · v``."""
    x, y, z = vector
    xx, xy, xz, _, yy, yz, _, _, zz = covariance
    return (x * xx + 2.0 * (y * xy + z * xz)) * x + (y * yy + 2.0 * z * yz) * y + z * zz * z


def isotropic(deviation: float) -> Matrix:
    """Return the covariance, shape (3, 3), of one deviation on every axis."""
    variance = deviation * deviation
    return (variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance)


def quaternion_from_matrix(rotation: Matrix) -> Quaternion:
    """Turn a rotation matrix, shape (3, 3), into its unit quaternion (x, y, z, w), w ≥ 0.

    Of the four ways to do it, that which divides by the largest element is taken (Shepperd 1978,
    doi:10.2514/3.55767b).
    """
    a, b, c, d, e, f, g, h, i = rotation
    trace = a + e + i
    if trace >= max(a, e, i):
        q = (h - f, c - g, d - b, 1.0 + trace)
    elif a >= max(e, i):
        q = (1.0 + a - e - i, b + d, c + g, h - f)
    elif e >= i:
        q = (b + d, 1.0 - a + e - i, f + h, c - g)
    else:
        q = (c + g, f + h, 1.0 - a - e + i, d - b)
    x, y, z, w = normalized(q)
    return (x, y, z, w) if w >= 0.0 else (-x, -y, -z, -w)
