"""Messages as tests send them."""

import numpy as np
from geometry_msgs.msg import AccelWithCovarianceStamped
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu

from dead_reckoning.core.rotation import matrix_from_quaternion, normalized

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


def realistic_samples(seed=3, rate=200.0):
    """A rest, a walk of the attitude under random pushes, and what can go wrong between."""
    random = np.random.default_rng(seed)
    attitude = np.array([0.02, -0.03, 0.1, 1.0])
    push = np.zeros(3)
    stamp_ns = START_NS
    for number in range(500):
        stamp_ns += round(NANOSECONDS / rate) + int(random.integers(-100_000, 100_000))
        moving = 130 <= number < 420
        if moving:
            attitude = attitude + 0.01 * random.standard_normal(4)
            push = 0.9 * push + random.standard_normal(3)
        else:
            push = np.zeros(3)
        # As many drivers hold it: not of unit length to the last bit.
        orientation = np.float32(normalized(tuple(attitude.tolist())))
        rot_ws = np.reshape(matrix_from_quaternion(tuple(orientation.tolist())), (3, 3))
        force = rot_ws.T @ (push + np.array([0.0, 0.0, GRAVITY]))
        force += 0.02 * random.standard_normal(3)
        message = imu_message(stamp_ns, force, orientation, 'sensor')
        match number:
            case 200:
                message.linear_acceleration.y = float('nan')
            case 210:
                message.linear_acceleration_covariance[4] = float('inf')
            case 220:
                message.orientation.w = float('nan')
            case 230:
                message.orientation_covariance[0] = -1.0
            case 240:
                message.linear_acceleration_covariance[:] = [0.0] * 9
                message.orientation_covariance[:] = [0.0] * 9
            case 250:
                message.angular_velocity_covariance[0] = 1e-4
                message.angular_velocity.z = 0.25
            case 260:
                message.header.stamp.sec -= 1  # late
            case 270:
                stamp_ns += 2 * NANOSECONDS  # and so a gap
            case 280:
                yield message  # twice
        yield message


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
