"""Settings of the integrator."""

from __future__ import annotations

from dataclasses import dataclass

from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.parameters import Settings, parameter

AXES = ('x', 'y', 'z')


@dataclass(frozen=True, kw_only=True)
class IntegratorSettings(Settings, prefix='integrator'):
    """How the integrator integrates, and when it holds the body for resting."""

    method: str = parameter(
        'trapezoid',
        'trapezoid (AN3397 and mbed, first order between samples), euler (CH Robotics section 3, '
        'the value before each step) or kalman (the errors of attitude and offset are learnt '
        'whenever the movement-end check makes the velocity known)',
        choices=('trapezoid', 'euler', 'kalman'),
    )
    axes: tuple[str, ...] = parameter(
        AXES,
        'Axes of the sensor along which it moves; the others are held at zero. With a single one '
        'the body carries its speed along as it turns: distance along a heading',
        choices=AXES,
    )
    window_minimum: float = parameter(
        -0.05,
        'Discrimination window: an acceleration along an axis of the sensor from window_minimum '
        'to window_maximum counts as none',
        unit='m/s²',
        maximum=0.0,
        mutable=True,
    )
    window_maximum: float = parameter(
        0.05, 'Upper end of the discrimination window', unit='m/s²', minimum=0.0, mutable=True
    )
    movement_end: str = parameter(
        'all',
        'Movement-end check, which returns the velocity to zero: all (once all axes are quiet '
        'together), each (axis by axis, as the documents do) or off',
        choices=('all', 'each', 'off'),
        mutable=True,
    )
    movement_end_samples: int = parameter(
        25,
        'Samples of rest in a row that end a movement; rest is being inside the window, or the '
        'mean of as many samples being inside it',
        minimum=1,
        maximum=1_000_000,
        mutable=True,
    )
    movement_end_deviation: float = parameter(
        0.15,
        'Largest standard deviation of an axis over these samples that still counts as rest; the '
        'tremor of a hand shows as 0.07',
        unit='m/s²',
        minimum=0.0,
        mutable=True,
    )
    max_gap: float = parameter(
        0.5,
        'Longest time between samples that is integrated; over a longer one position and velocity '
        'are held and uncertainty grows',
        unit='s',
        minimum=0.001,
        maximum=60.0,
    )
    gap_acceleration: float = parameter(
        1.0, 'One sigma of the acceleration that a gap may hide', unit='m/s²', minimum=0.0
    )
    offset_deviation: float = parameter(
        0.01,
        'One sigma of the constant offset that calibration leaves on an axis',
        unit='m/s²',
        minimum=0.0,
    )
    scale_deviation: float = parameter(
        0.01,
        "One sigma of the relative error of the sensor's sensitivity, which scales the whole path",
        minimum=0.0,
        maximum=1.0,
    )
    heading_deviation: float = parameter(
        0.04,
        'One sigma of the part of the heading error that changes as the body turns, as iron near '
        'a compass makes it; with a single axis only',
        unit='rad',
        minimum=0.0,
        maximum=3.2,
    )
    bias_walk: float = parameter(
        0.001,
        'One sigma by which the offset wanders in a second; method kalman only',
        unit='m/s²/√s',
        minimum=0.0,
    )
    stationary_deviation: float = parameter(
        0.01,
        'One sigma of the velocity that the movement-end check may overlook',
        unit='m/s',
        minimum=0.0,
    )
    calibration_duration: float = parameter(
        1.0, 'How long ~/calibrate averages', unit='s', minimum=0.05, maximum=600.0
    )
    calibration_deviation: float = parameter(
        0.3,
        'Largest standard deviation of an axis at which ~/calibrate still believes in rest',
        unit='m/s²',
        minimum=1e-6,
        maximum=5.0,
    )

    def validate(self) -> None:
        """Raise `SettingsError` where the window holds nothing but zero and the check needs it."""
        if self.movement_end != 'off' and self.window_minimum == self.window_maximum:
            raise SettingsError(
                'integrator.window_maximum: 0.0 leaves the movement-end check nothing that counts '
                'as quiet; widen the window or set integrator.movement_end to off'
            )
