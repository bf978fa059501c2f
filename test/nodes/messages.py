"""Messages as tests send them."""

from geometry_msgs.msg import AccelWithCovarianceStamped
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu

GRAVITY = 9.80665
NANOSECONDS = 1_000_000_000
START_NS = 1_000 * NANOSECONDS
"""Stamp of the first sample of a test; any but zero will do."""


def stamped(message, stamp_ns, frame_id):
    sec, nanosec = divmod(stamp_ns, NANOSECONDS)
    message.header.stamp.sec, message.header.stamp.nanosec = sec, nanosec
    message.header.frame_id = frame_id
    return message


def fill(message, names, values):
    for name, value in zip(names, values, strict=True):
        setattr(message, name, float(value))


def imu_message(stamp_ns, force, orientation=None, frame_id='imu_link'):
    """Return an Imu: specific force [m/s²], and orientation (x, y, z, w) if it has one."""
    message = stamped(Imu(), stamp_ns, frame_id)
    fill(message.linear_acceleration, 'xyz', force)
    message.linear_acceleration_covariance = [1e-4, 0.0, 0.0, 0.0, 1e-4, 0.0, 0.0, 0.0, 1e-4]
    message.angular_velocity_covariance[0] = -1.0
    if orientation is None:
        message.orientation_covariance[0] = -1.0
    else:
        fill(message.orientation, 'xyzw', orientation)
        message.orientation_covariance = [1e-6, 0.0, 0.0, 0.0, 1e-6, 0.0, 0.0, 0.0, 1e-6]
    return message


def acceleration_message(stamp_ns, acceleration):
    """Return a linear acceleration [m/s²] in the world."""
    message = stamped(AccelWithCovarianceStamped(), stamp_ns, 'odom')
    fill(message.accel.accel.linear, 'xyz', acceleration)
    return message


def clock_message(now_ns):
    """Return what /clock says at a time."""
    message = Clock()
    message.clock.sec, message.clock.nanosec = divmod(now_ns, NANOSECONDS)
    return message


class Feed:
    """Publishes samples whose stamps go on at a steady rate, as fast as they are taken."""

    PATIENCE = 0.002

    def __init__(self, ros, publish, rate=200.0, start_ns=START_NS):
        self._ros = ros
        self._publish = publish
        self.step_ns = round(NANOSECONDS / rate)
        self.stamp_ns = start_ns

    def send(self, *values):
        """Publish one sample."""
        self.stamp_ns += self.step_ns
        self._publish(self.stamp_ns, *values)

    def send_until(self, condition, what, *values):
        """Publish samples, letting the test's node take what comes back, until a condition."""

        def sent():
            self.send(*values)
            return condition()

        return self._ros.until(sent, what, self.PATIENCE)
