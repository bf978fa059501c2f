"""The cases that the demo shows: what moves, with which settings, and how to look at it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.stages import ACCELERATION, COMPASS, GROUND_TRUTH, ODOMETRY, STEPS
from dead_reckoning.sources.motions import Steps
from dead_reckoning.sources.motions.walk import Walk, WalkSettings
from dead_reckoning.tools.demo.views import AlongAxis, AlongHeading, InPlane, OnFoot, View
from dead_reckoning.tools.presets import values_of


@dataclass(frozen=True)
class Setup:
    """Which ``nodes`` to start, and once they have found each other the ``source``.

    ``ends`` are the publishers and subscribers together that topics have by then, the recorder's
    among them; ``listeners`` the subscribers of `imu/data_raw` and `ground_truth/odom` together
    that the source waits for.
    """

    nodes: tuple[str, ...]
    source: str
    ends: Mapping[str, int]
    listeners: int


CHAIN = Setup(
    ('integrator', 'gravity_removal'),
    'accelerometer_driver',
    {ODOMETRY: 2, ACCELERATION: 3},
    listeners=2,
)
WALKER = Setup(
    ('pedometer', 'compass_driver'),
    'accelerometer_driver',
    {STEPS: 2, COMPASS: 2, GROUND_TRUTH: 2},
    listeners=3,
)
WITH_COMPASS = Setup(('compass_driver',), 'pipeline', {COMPASS: 1, GROUND_TRUTH: 2}, listeners=2)


@dataclass(frozen=True)
class Case:
    """One run of the demo.

    ``parameters`` go to every node, full keys; ``duration`` [s] is how long to record, ``start``
    [s] the rest before the motion.
    """

    name: str
    title: str
    words: str
    parameters: Mapping[str, Any]
    duration: float
    view: View
    setup: Setup = CHAIN
    start: float = 4.0

    @property
    def all_parameters(self) -> dict[str, Any]:
        """The parameters with those that every case has."""
        motion = self.parameters['driver.motion']
        return {
            **self.parameters,
            f'driver.{motion}.start': self.start,
            'driver.wait_for_subscribers': self.setup.listeners,
        }


SLIDE = {'driver.motion': 'slide', 'driver.slide.distance': 0.5, 'driver.slide.duration': 1.0}

WALK = {
    **values_of('an900'),
    'driver.walk.roll': 0.0,
    'driver.walk.heading': 0.5,
    'pedometer.axes': ['x', 'y', 'z'],
}

MBED = {
    key: value
    for key, value in values_of('mbed').items()
    if key not in ('pipeline.log_csv', 'pipeline.duration')
}


def _steps(parameters: Mapping[str, Any]) -> Steps:
    return Walk(Configuration(parameters)[WalkSettings]).steps


CASES = (
    Case(
        name='slide',
        title='Slide of 0.5 m',
        words='A ±1.5 g MMA7260QT behind a 12-bit ADC rests, slides from A to B, and rests again: '
        "AN3397's figure 8. Offset, scale error, misalignment, noise and quantisation are on; the "
        'driver calibrates at rest, gravity is removed, the trapezoid integrates twice, and the '
        'movement-end check returns the velocity to zero.',
        parameters=SLIDE,
        duration=6.5,
        view=AlongAxis(0),
    ),
    Case(
        name='slide-8-bit',
        title='The same slide with the sensor of AN3397: 8 bits, a window of ±3 counts',
        words='A count is 16 mg here, and up to ±3 of them are taken for no motion at all. What '
        'lies inside of that window at the start and at the end of a slide is lost, and so is a '
        'slow push. 1024 and 64 conversions are averaged, which helps little where noise is '
        'smaller than a count.',
        parameters={
            **SLIDE,
            'driver.adc_bits': 8,
            'integrator.axes': ['x', 'y'],
            'integrator.window_minimum': -0.474,
            'integrator.window_maximum': 0.474,
            'integrator.movement_end': 'each',
        },
        duration=6.5,
        view=AlongAxis(0),
    ),
    Case(
        name='square',
        title='A square of 0.3 m, back to where it began',
        words="AN3397's mouse, with the 12-bit sensor: four slides with a rest at each corner, at "
        'which the velocity returns to zero. Errors of the sides add up.',
        parameters={'driver.motion': 'square', 'driver.square.side': 0.3},
        duration=11.0,
        view=InPlane(),
    ),
    Case(
        name='lift',
        title='Three metres up in a lift',
        words='Along the vertical the error of gravity itself counts: it is measured at rest '
        'before the ride. Constant speed looks like rest to an accelerometer, so the '
        'movement-end check has to be off; nothing returns the velocity to zero then.',
        parameters={
            'driver.motion': 'lift',
            'driver.lift.height': 3.0,
            'integrator.movement_end': 'off',
            'integrator.window_minimum': 0.0,
            'integrator.window_maximum': 0.0,
        },
        duration=9.0,
        view=AlongAxis(2),
    ),
    Case(
        name='walk',
        title='A walk of 60 steps',
        words="AN-900's pedometer: an ADXL330 on the belt, worn level here, as the compass beside "
        'it has to be; 30 messages a second, steps counted on all axes. Each is as long as '
        'equation (2) makes of the bounce, and leads where the compass points. Nothing has been '
        'calibrated for this walker.',
        parameters=WALK,
        duration=40.0,
        view=OnFoot(_steps({**WALK, 'driver.walk.start': 4.0})),
        setup=WALKER,
    ),
    Case(
        name='mbed',
        title='18 m round an eight, along the heading of a compass',
        words='The mbed tutorial "Dead Reckoning", on a vehicle: an ADXL345 at 3200 Hz, averaged '
        'to 100 Hz, and one axis of it integrated to a distance along the heading, with three '
        'stops. The compass has not been turned around to calibrate it, so iron nearby turns its '
        'headings by up to 3°.',
        parameters=MBED,
        duration=16.0,
        view=AlongHeading(digits=2),
        setup=WITH_COMPASS,
    ),
)
