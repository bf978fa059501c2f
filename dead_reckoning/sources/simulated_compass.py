"""A simulated compass: the magnetic field in the axes of a body whose true attitude is known."""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import dataclass
from math import atan2, cos, pi, radians, sin, tan

import numpy as np

from dead_reckoning.core.chain import FAULT, Output, Stage
from dead_reckoning.core.compass import Compass, CompassSettings
from dead_reckoning.core.errors import CalibrationError, RestartError
from dead_reckoning.core.hard_iron import HardIronCalibration
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.rotation import matrix_from_quaternion, normalized, rotate_back
from dead_reckoning.core.samples import NANOSECONDS, NavigationState, Quaternion, Vector
from dead_reckoning.core.stages import COMPASS, GROUND_TRUTH
from dead_reckoning.core.stamps import Timeline
from dead_reckoning.core.work import Work


@dataclass(frozen=True, kw_only=True)
class SimulatedCompassSettings(Settings, prefix='compass.simulated'):
    """The field at the place of the simulated compass, and what spoils its headings."""

    seed: int = parameter(1, 'Seed of the noise', minimum=0)
    noise: bool = parameter(True, 'Whether it has the noise that compass.noise says')
    quantise: bool = parameter(True, 'Whether it rounds as compass.resolution says')
    iron: tuple[float, float] = parameter(
        (0.05, -0.03), 'What iron nearby adds along x and y, as a part of the horizontal field',
        minimum=-0.6, maximum=0.6, length=2,
    )  # fmt: skip
    declination: float = parameter(
        0.0, 'How far magnetic north really lies east of true north', unit='rad',
        minimum=-3.2, maximum=3.2,
    )  # fmt: skip
    dip: float = parameter(
        radians(60.0), 'How steeply the field points down, which turns tilt into wrong headings; '
        '0 for a compass that makes up for tilt', unit='rad', minimum=-1.5, maximum=1.5,
    )  # fmt: skip


class SimulatedCompass:
    """Read the direction of the horizontal field in the body's axes, as a two-axis compass does.

    The field in the world, its horizontal part as unit, is (sin D, cos D, −tan dip) with the
    declination D.  Turned into the body, with iron and noise added along x and y,
    ``heading = atan2(m_y, m_x)``: clockwise from magnetic north, if the body is level.
    """

    STREAM = 2
    """Sets its random numbers apart from those of other sensors with the same seed."""

    def __init__(self, simulated: SimulatedCompassSettings, settings: CompassSettings) -> None:
        declination = simulated.declination
        self._field_w: Vector = (sin(declination), cos(declination), -tan(simulated.dip))
        self._iron = simulated.iron
        self._noise = settings.noise if simulated.noise else 0.0
        self._resolution = settings.resolution if simulated.quantise else 0.0
        self._calibration_time = settings.calibration_time
        self._random = np.random.default_rng((simulated.seed, self.STREAM))
        self._calibration: HardIronCalibration | None = None
        self._work = Work()
        self.offset = (0.0, 0.0)
        """What a calibration found iron to add along x and y, and takes off."""

    def calibrate(self) -> Future[str]:
        """Find what iron adds while the body turns once around, as HMC6352's `C` and `E` do.

        The future ends with a sentence for the user, or with `CalibrationError`; the offset in
        force changes only if it succeeds.
        """
        self._calibration = HardIronCalibration(self._calibration_time)
        return self._work.begin()

    def abandon(self, reason: str) -> None:
        """End a calibration that can't go on."""
        self._calibration = None
        self._work.fail(CalibrationError(reason))

    def read(self, stamp_ns: int, attitude: Quaternion) -> float:
        """Return the heading [rad] of a body with this attitude; raises `NotFiniteError`."""
        field = rotate_back(matrix_from_quaternion(normalized(attitude)), self._field_w)
        noise = self._random.standard_normal(2)
        x = field[0] + self._iron[0] + self._noise * float(noise[0])
        y = field[1] + self._iron[1] + self._noise * float(noise[1])
        if self._calibration is not None:
            self._calibrate(self._calibration, stamp_ns, x, y)
        heading = atan2(y - self.offset[1], x - self.offset[0])
        if self._resolution > 0.0:
            heading = round(heading / self._resolution) * self._resolution
        return heading % (2.0 * pi)

    def _calibrate(
        self, calibration: HardIronCalibration, stamp_ns: int, x: float, y: float
    ) -> None:
        try:
            if not calibration.add(stamp_ns, x, y):
                return
            self.offset = calibration.finish()
        except CalibrationError as error:
            self._calibration = None
            self._work.fail(error)
            return
        self._calibration = None
        said = ', '.join(f'{part:+.3f}' for part in self.offset)
        self._work.succeed(f'iron adds {said} of the horizontal field along x, y: taken off')


def compass_stage(compass: SimulatedCompass, settings: CompassSettings, frame_id: str) -> Stage:
    """Take the true state of the body; give a sample with the first of each period.

    Periods are counted from stamp 0, so two compasses read at the same moments, whenever they were
    started.
    """
    model = Compass(settings, frame_id)
    timeline = Timeline()
    period_ns = round(NANOSECONDS / settings.rate)
    period = -1

    def take(truth: NavigationState) -> list[Output]:
        nonlocal period
        outputs: list[Output] = []
        restarts, stamp_ns = timeline.restarts, truth.stamp_ns
        timeline.advance(stamp_ns)
        if timeline.restarts != restarts:
            compass.abandon('the stamps went back meanwhile: ask again')
            outputs.append((FAULT, RestartError('the stamps went back: the compass goes on')))
        if stamp_ns // period_ns != period:
            period = stamp_ns // period_ns
            heading = compass.read(stamp_ns, truth.attitude)
            outputs.append((COMPASS, model.sample(stamp_ns, heading)))
        return outputs

    return {GROUND_TRUTH: take}
