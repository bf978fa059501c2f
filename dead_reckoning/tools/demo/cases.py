"""The cases that the demo shows: what moves, with which settings, and how to look at it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from dead_reckoning.tools.demo.views import AlongAxis, InPlane, View


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
    start: float = 4.0

    @property
    def all_parameters(self) -> dict[str, Any]:
        """The parameters with those that every case has."""
        motion = self.parameters['driver.motion']
        return {
            **self.parameters,
            f'driver.{motion}.start': self.start,
            'driver.wait_for_subscribers': 1,
        }


SLIDE = {'driver.motion': 'slide', 'driver.slide.distance': 0.5, 'driver.slide.duration': 1.0}

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
)
