"""What a compass says of the attitude: its headings as samples with a yaw."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, radians

from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.rotation import quaternion_from_euler
from dead_reckoning.core.samples import (
    NOT_MEASURED,
    UNMEASURED_VARIANCE,
    ZERO,
    ImuSample,
    Matrix,
)


@dataclass(frozen=True, kw_only=True)
class CompassSettings(Settings, prefix='compass'):
    """A compass, and how well its headings are known."""

    source: str = parameter(
        'simulated', 'Where headings come from', choices=('simulated', 'hmc6352')
    )
    rate: float = parameter(
        20.0, 'Headings per second (HMC6352: 1, 5, 10 or 20)', unit='Hz',
        minimum=0.1, maximum=1000.0,
    )  # fmt: skip
    noise: float = parameter(
        radians(0.5), 'Noise of one heading, one sigma', unit='rad', minimum=0.0, maximum=1.0
    )
    resolution: float = parameter(
        radians(0.1), 'Size of one count of the heading; 0 for no rounding', unit='rad',
        minimum=0.0, maximum=1.0,
    )  # fmt: skip
    deviation: float = parameter(
        radians(2.5), 'One sigma of what noise does not explain: iron nearby, tilt; HMC6352: 2.5°',
        unit='rad', minimum=0.0, maximum=3.2,
    )  # fmt: skip
    declination: float = parameter(
        0.0, 'How far magnetic north lies east of true north here; it is added to headings',
        unit='rad', minimum=-3.2, maximum=3.2,
    )  # fmt: skip
    calibration_time: float = parameter(
        15.0, 'How long a full turn may take when the compass is calibrated', unit='s',
        minimum=0.5, maximum=600.0,
    )  # fmt: skip


class Compass:
    """Turn headings, clockwise from magnetic north, into yaw, left-hand from east.

    ``yaw = π/2 − (heading + declination)``, with the variance
    ``noise² + resolution²/12 + deviation²``.  Roll and pitch come with a huge variance, force and
    rate as not measured.  Each heading stands alone: gaps and stale stamps are for who uses them.
    """

    def __init__(self, settings: CompassSettings, frame_id: str) -> None:
        """``frame_id`` of the sensor."""
        self._declination = settings.declination
        self._frame_id = frame_id
        variance = settings.noise**2 + settings.resolution**2 / 12.0 + settings.deviation**2
        huge = UNMEASURED_VARIANCE
        self._covariance: Matrix = (huge, 0.0, 0.0, 0.0, huge, 0.0, 0.0, 0.0, variance)

    def sample(self, stamp_ns: int, heading: float) -> ImuSample:
        """Return the sample of a heading [rad]."""
        yaw = 0.5 * pi - (heading + self._declination)
        return ImuSample(
            stamp_ns,
            self._frame_id,
            ZERO,
            NOT_MEASURED,
            orientation=quaternion_from_euler(0.0, 0.0, yaw),
            orientation_covariance=self._covariance,
        )
