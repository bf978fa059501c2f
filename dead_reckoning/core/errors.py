"""The errors this package raises on purpose: one root, a subclass per cause.

Core raises them; a node catches the root only, counts the cause by its class name, says it once in
a while and drops the sample.  Every message names the value at fault and the remedy.
"""

from typing import ClassVar


class DeadReckoningError(Exception):
    """Root of all errors that this package raises on purpose.

    ``severity`` is that of the line in the log: a warning where the work goes on without the
    sample, or with a doubt; an error where what comes out is wrong or missing; none where it is
    to be expected, and only counted.
    """

    severity: ClassVar[str] = 'error'


class SettingsError(DeadReckoningError):
    """A parameter is unknown, of the wrong type or outside what is allowed."""


class SampleError(DeadReckoningError):
    """A sample can't be used; the estimator's state is as it was before it."""

    severity = 'warning'


class NotFiniteError(SampleError):
    """A sample holds NaN, an infinity, or a number or covariance that no measurement has."""


class ZeroStampError(SampleError):
    """A sample carries the stamp 0, which is no time at all."""


class RepeatedStampError(SampleError):
    """A sample carries the stamp of the one before it."""


class LateSampleError(SampleError):
    """A sample is older than one that was used already."""


class MissingAttitudeError(SampleError):
    """A sample carries no orientation, and the chosen source of attitude needs one."""


class MissingRateError(SampleError):
    """A sample carries no angular velocity, and the chosen source of attitude needs one."""


class MissingAccelerationError(SampleError):
    """A sample says, by covariance[0] = -1, that its device measures no acceleration."""


class MissingMountingError(SampleError):
    """A sample came before TF said how its sensor sits on the body."""


class NotLevelledError(SampleError):
    """A sample came before the attitude at rest was known."""


class UnpairedError(SampleError):
    """A linear acceleration and an attitude never found the partner with their stamp."""


class AidingError(SampleError):
    """A velocity or a pose from elsewhere can't be used: its frame, covariance or stamp."""


class NotAtRestError(DeadReckoningError):
    """The device moved while it had to rest."""


class GravityError(DeadReckoningError):
    """At rest the specific force is not within 10 % of gravity: the input is silently wrong."""


class MountingError(DeadReckoningError):
    """Gravity is far from the up axis: fine for a tilted mounting, else a wrong sign or NED."""

    severity = 'warning'


class RestartError(DeadReckoningError):
    """The stamps went back by more than 1 s: an estimator has started over."""

    severity = 'warning'


class DivergedError(DeadReckoningError):
    """What an estimator holds is no state any more, not finite: it has started over."""


class GapError(DeadReckoningError):
    """Samples were missing for longer than may be integrated."""

    severity = 'warning'


class StaleCompassError(DeadReckoningError):
    """The compass fell silent: the yaw is no longer what it says."""

    severity = 'warning'


class SilentInputError(DeadReckoningError):
    """A topic fell silent, or never brought anything while its partner does."""

    severity = 'warning'


class SeveralPublishersError(DeadReckoningError):
    """More than one node publishes what is taken for the samples of one sensor."""

    severity = 'warning'


class MismatchError(DeadReckoningError):
    """Type or quality of service of a topic differ, so that nothing passes."""


class ClockError(DeadReckoningError):
    """The node goes by /clock, and /clock stands or never came."""

    severity = 'warning'


class CalibrationError(DeadReckoningError):
    """An offset found at rest is beyond what the sensor can have."""


class StepCalibrationError(DeadReckoningError):
    """The constant of the step length can't be found: nothing was begun, or nobody walked."""


class StateFileError(DeadReckoningError):
    """The file that keeps the totals of a pedometer can't be written."""


class DamagedStateError(DeadReckoningError):
    """The file that keeps the totals of a pedometer is not as it was written."""


class SupersededError(DeadReckoningError):
    """A task was asked for again before it ended."""


class WireError(DeadReckoningError):
    """Bytes are not the message they were taken for."""


class EncodingError(WireError):
    """Bytes are a message in another encoding than little-endian CDR, or none."""


class ReadingError(DeadReckoningError):
    """Bytes of a board hold no reading that can be used; a subclass says why."""

    severity = 'warning'


class CutError(ReadingError):
    """A reading lacks its beginning or its end, where the port was opened or lost."""

    severity = 'none'


class GarbledError(ReadingError):
    """A line of a board is no text."""


class OverlongError(ReadingError):
    """A line of a board does not end."""


class ColumnError(ReadingError):
    """A line of a board has more or fewer columns than it should."""


class NumberError(ReadingError):
    """A column of a line holds no number."""


class OutOfRangeError(ReadingError):
    """A reading is outside of what the converter can give."""


class FrameError(ReadingError):
    """Bytes are no frame of the board they were taken for."""


class BoardError(ReadingError):
    """A board is not set as the parameters say, so its readings would be taken for others."""

    severity = 'error'


class IncompleteError(ReadingError):
    """Of what a board sends apart and makes one reading, something is missing."""


class HealthError(ReadingError):
    """A board says of itself that a part of it fails."""


class OverrunError(ReadingError):
    """The memory of a sensor ran over before it was read: samples are lost."""


class PortError(DeadReckoningError):
    """A serial port can't be read; a subclass says why, where that is known."""


class MissingPortError(PortError):
    """There is no such serial port."""


class PortPermissionError(PortError):
    """The serial port belongs to others."""


class BusyPortError(PortError):
    """Another program reads the serial port."""


class LostPortError(PortError):
    """The serial port went away while it was read: unplugged, or hung up."""


class SilentPortError(PortError):
    """The serial port is open, and no reading comes from it."""


class DeviceError(DeadReckoningError):
    """A sensor on a bus or of the kernel can't be read; a subclass says why, where it is known."""


class MissingDeviceError(DeviceError):
    """There is no such device, or nothing answers at its address."""


class DevicePermissionError(DeviceError):
    """The device belongs to others."""


class BusyDeviceError(DeviceError):
    """Another program reads the device."""


class WrongDeviceError(DeviceError):
    """What answers is another device than was asked for."""


class RefusedSettingError(DeviceError):
    """The device does not take a rate, a range or a mode."""


class LostDeviceError(DeviceError):
    """The device went away while it was read, or lost its supply."""


class SilentDeviceError(DeviceError):
    """The device is there, and no reading comes from it."""


class RecordingError(DeadReckoningError):
    """A recording can't be read, or does not hold what was asked of it."""


class InputError(DeadReckoningError):
    """A file or an option given to a tool can't be used; file, line and value are named."""


class DependencyError(DeadReckoningError):
    """Something that was asked for needs a package that is not installed."""
