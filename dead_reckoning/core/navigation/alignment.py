"""Align the navigator at rest: what its filter begins with."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, hypot

import numpy as np

from dead_reckoning.core.blocks import Array, Stamps
from dead_reckoning.core.errors import GravityError, NotLevelledError
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.rest import check_gravity, level_variances
from dead_reckoning.core.rest_search import RestSearch, Stillness
from dead_reckoning.core.rotation import (
    euler_from_gravity,
    matrix_from_quaternion,
    quaternion_from_euler,
)
from dead_reckoning.core.samples import NANOSECONDS, ImuSample, Vector

KNOWN = 1e-10
"""Variance of what is zero by definition at the start: position and yaw [m², rad²]."""

AT_REST = 1e-4
"""Variance of the velocity at the start [m²/s²]."""

WEAKER = 10.0
"""So many times the variance of a rest's mean is that of the tilt at the start.

The samples of that rest go through the filter, and so must not count twice.
"""

LEVEL_FLOOR = 1e-3
"""One sigma of the force at a rest that nothing shows better [m/s²]."""

RULES = (
    'acceleration_noise', 'sampling_noise', 'rate_noise', 'rate_walk', 'acceleration_walk',
    'zero_velocity', 'stance_velocity', 'pivot', 'height', 'correlation', 'gate', 'patience',
    'axis_gate', 'zero_rate', 'still_window', 'still_deviation', 'still_noise', 'sway',
    'floor_deviation', 'floor_gate', 'floor_slope', 'max_gap', 'gap_speed', 'force_range',
    'rate_range', 'gravity_direction', 'held_velocity', 'held_time', 'nonholonomic', 'slip',
    'slip_angle', 'slip_time', 'averaging', 'rate_scale', 'aiding_gate', 'aiding_patience',
    'aiding_correlation',
)  # fmt: skip
"""Settings that the kernel takes as they are, under the same names."""


@dataclass(frozen=True, slots=True, eq=False)
class Rest:
    """A rest to align at: what it showed, gravity [m/s²], and its samples.

    ``rows``, shape (n, ROW), and ``stamps``, shape (n,), are as kernels take them, ``rate`` [Hz]
    is how many there are in a second.
    """

    still: Stillness
    gravity: float
    rows: Array
    stamps: Stamps
    rate: float


class Alignment:
    """Collect the samples of the first rest."""

    def __init__(self, settings: NavigatorSettings) -> None:
        self._settings = settings
        self._wrong: GravityError | None = None  # with the last rest, which was none
        self.clear()

    def clear(self) -> None:
        """Look for rest anew."""
        self._search = RestSearch(self._settings, with_rate=True)
        self._stamps: list[int] = []
        self._rows: list[tuple[float, ...]] = []

    def add(self, imu: ImuSample, rate_variance: float) -> Rest:
        """Take a sample; return the rest once there is one.

        Raises `NotLevelledError` before, and `NotAtRestError` or `GravityError` where the window
        that is full now was none; it begins anew then.
        """
        self._stamps.append(imu.stamp_ns)
        turn = imu.angular_velocity or ()
        self._rows.append((0.0, *imu.specific_force, *turn, rate_variance))
        stamps, rows = self._stamps, self._rows
        still = self._search.add(imu)
        if still is None:
            if self._wrong is not None:
                raise NotLevelledError(f'waiting for rest: {self._wrong}') from self._wrong
            raise NotLevelledError(
                'waiting for rest: the tilt is taken from gravity, so keep the device still '
                f'for {self._settings.rest_duration:g} s'
            )
        try:
            gravity = check_gravity(still.force.mean)
        except GravityError as error:
            self._wrong = error
            raise
        samples = np.array(rows)
        samples[1:, 0] = np.diff(stamps) / NANOSECONDS
        rate = (len(stamps) - 1) * NANOSECONDS / (stamps[-1] - stamps[0])
        return Rest(still, gravity, samples, np.array(stamps), rate)


def first_state(
    rest: Rest, yaw: float, yaw_variance: float, settings: NavigatorSettings, rings: int
) -> tuple[Array, str]:
    """Return the state that the filter begins with, and what it is in words."""
    state = np.zeros(layout.RINGS + rings)
    roll, pitch = euler_from_gravity(rest.still.force.mean)
    attitude = quaternion_from_euler(roll, pitch, yaw)
    state[layout.X_ATTITUDE : layout.X_ATTITUDE + 4] = attitude
    state[layout.NOISE] = -1.0  # no rest yet
    variances = np.full(layout.ERRORS, KNOWN)
    variances[layout.VELOCITY : layout.VELOCITY + 3] = AT_REST
    noise = settings.acceleration_noise**2 / settings.rest_duration
    variances[layout.ATTITUDE : layout.ATTITUDE + 2] = WEAKER * noise / rest.gravity**2
    variances[layout.ATTITUDE + 2] = yaw_variance
    variances[layout.RATE_BIAS : layout.RATE_BIAS + 3] = settings.rate_bias**2
    variances[layout.FORCE_BIAS : layout.FORCE_BIAS + 3] = settings.acceleration_bias**2
    # What the accelerometer is biased by is a tilt: θ_x = −(R b_a)_y/g, θ_y = (R b_a)_x/g.
    rot_ws = np.reshape(matrix_from_quaternion(attitude), (3, 3))
    with_bias = np.eye(layout.ERRORS)
    columns = slice(layout.FORCE_BIAS, layout.FORCE_BIAS + 3)
    with_bias[layout.ATTITUDE, columns] = -rot_ws[1] / rest.gravity
    with_bias[layout.ATTITUDE + 1, columns] = rot_ws[0] / rest.gravity
    covariance = (with_bias * variances @ with_bias.T).ravel()
    state[layout.COVARIANCE : layout.COVARIANCE + len(covariance)] = covariance
    return state, said(rest.gravity, rest.still.force.mean)


def level_at(
    still: Stillness, force_bias: Vector, settings: NavigatorSettings
) -> tuple[float, tuple[float, ...], str]:
    """Return gravity [m/s²], the values of a `LEVEL`, and what a rest on the way shows in words.

    ``force_bias``, shape (3,) [m/s²], is what the filter holds for that of the accelerometer.
    """
    assert still.rate is not None
    x, y, z = (f - b for f, b in zip(still.force.mean, force_bias, strict=True))
    gravity, duration = hypot(x, y, z), settings.rest_duration
    of_force = gravity**2 * level_variances(still.force)[1] + LEVEL_FLOOR**2
    of_rate = 2.0 * (settings.sway / duration) ** 2 + settings.rate_noise**2 / duration
    turns = ', '.join(f'{degrees(b):.3f}' for b in still.rate.mean)
    values = (*still.force.mean, *still.rate.mean, of_force, of_rate)
    return gravity, values, f'{said(gravity, (x, y, z))}, gyro bias {turns} °/s'


def said(gravity: float, force: Vector) -> str:
    """Say in words what a rest showed; ``force`` shape (3,) [m/s²], frame of the sensor."""
    roll, pitch = euler_from_gravity(force)
    return f'gravity is {gravity:.4f} m/s², roll {degrees(roll):.3f}°, pitch {degrees(pitch):.3f}°'


def rules_of(settings: NavigatorSettings, gap_turn: float, rate: float, delay: int) -> Array:
    """Return what the kernel goes by, but for gravity; ``rate`` of samples [Hz]."""
    rules = np.zeros(layout.RULES)
    for name in RULES:
        rules[getattr(layout, name.upper())] = getattr(settings, name)
    rules[layout.AXLE : layout.AXLE + 3] = settings.axle
    if not settings.floor:
        rules[layout.FLOOR_DEVIATION] = 0.0
    if settings.acceleration_bias == 0.0:
        rules[layout.ACCELERATION_WALK] = 0.0
    rules[layout.GAP_TURN] = gap_turn
    rules[layout.STILL_SAMPLES] = max(4, round(settings.still_window * rate))
    rules[layout.DELAY] = delay
    return rules
