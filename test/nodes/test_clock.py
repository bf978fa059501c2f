"""Simulated time: the driver's stamps follow /clock, and nothing else needs a clock."""

from itertools import pairwise

import pytest
from messages import NANOSECONDS, clock_message
from nav_msgs.msg import Odometry
from ros_harness import EXECUTORS, figures, lossless
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu

STEP_NS = NANOSECONDS // 50
PER_MESSAGE_NS = NANOSECONDS // 100


@pytest.fixture(params=EXECUTORS)
def driver(ros, request):
    """A driver that waits for a clock, and the means to give it one."""
    ros.start(
        'accelerometer_driver',
        {
            **lossless('/imu/data_raw', '/ground_truth/odom'),
            'use_sim_time': True,
            'common.executor': request.param,
            'driver.slide.start': 0.5,
        },
    )
    return Driver(ros)


class Driver:
    def __init__(self, ros):
        self._ros = ros
        self.raw = ros.record('imu/data_raw', Imu).connected()
        self.truth = ros.record('ground_truth/odom', Odometry).connected()
        self._clock = ros.publisher('/clock', Clock)
        ros.get('accelerometer_driver', 'use_sim_time')  # now it hears the clock from its start

    def run(self, start, end):
        """Let the clock go from one time [s] to another, and wait for the driver to follow."""
        now_ns, end_ns = round(start * NANOSECONDS), round(end * NANOSECONDS)
        while now_ns < end_ns:
            self._clock.publish(clock_message(now_ns))
            self._ros.for_seconds(0.002)
            now_ns += STEP_NS

        def caught_up():
            # Nodes listen to /clock best-effort, and so may miss any.
            self._clock.publish(clock_message(end_ns))
            return end_ns - PER_MESSAGE_NS < self.raw.latest_stamp <= end_ns

        self._ros.until(caught_up, 'the driver to catch up')


def test_driver_waits_for_the_clock_and_follows_it(ros, driver):
    ros.for_seconds(0.5)
    assert not driver.raw.messages, 'there is no time yet'
    driver.run(100.0, 102.0)
    # The calibration at the start takes 0.16 s; a stamp is the middle of its block.
    assert 100.16 < driver.raw.stamps[0] / NANOSECONDS < 100.3
    steps = {b - a for a, b in pairwise(driver.raw.stamps)}
    assert max(abs(step - PER_MESSAGE_NS) for step in steps) <= 1
    ros.until(lambda: driver.truth.stamps[-1:] == driver.raw.stamps[-1:], 'the truth')
    assert driver.truth.messages[-1].pose.pose.position.x == pytest.approx(0.5)
    assert driver.raw.stamps[-1] <= 102 * NANOSECONDS, 'nothing from the future'
    standing = len(driver.raw)
    ros.for_seconds(0.5)
    assert len(driver.raw) == standing, 'the clock stands still'


def test_a_clock_that_goes_back_starts_the_driver_anew(ros, driver):
    driver.run(100.0, 102.0)
    seen = len(driver.raw)
    driver.run(50.0, 50.9)
    again = driver.raw.stamps[seen:]
    assert 50.16 < again[0] / NANOSECONDS < 50.3
    assert again == sorted(again)
    ros.until(lambda: driver.truth.latest_stamp == again[-1], 'the truth')
    truth = driver.truth.messages[-1].pose.pose.position.x
    assert 0.0 < truth < 0.4, 'the slide has begun anew'


def test_a_small_step_back_of_the_clock_repeats_nothing(driver):
    driver.run(100.0, 101.0)
    driver.run(100.6, 101.5)
    assert driver.raw.stamps == sorted(set(driver.raw.stamps))


def test_a_looped_bag_starts_the_whole_chain_anew(ros):
    """Under use_sim_time all nodes wait while the bag is paused, and go on when it loops."""
    common = {
        'use_sim_time': True,
        'common.input_timeout': 1.0,
        **lossless('/imu/data_raw', '/imu/data', '/imu/linear_acceleration', '/ground_truth/odom'),
    }
    slide = {'driver.slide.start': 0.8, 'driver.wait_for_subscribers': 5}
    ros.start('accelerometer_driver', {**common, **slide})
    chain = ('gravity_removal', 'integrator', 'pedometer', 'compass_driver')
    nodes = [ros.start(name, common) for name in chain]
    driver = Driver(ros)
    odom = ros.record('odom', Odometry).connected()
    diagnostics = ros.diagnostics()
    driver.run(100.0, 103.0)
    ros.until(lambda: odom.latest_stamp > 102.5 * NANOSECONDS, 'odom')
    assert odom.messages[-1].pose.pose.position.x == pytest.approx(0.5, rel=0.1)
    for name in chain:
        diagnostics.until(name, lambda s: 'SilentInputError' in figures(s), 'the bag is paused')
    driver.run(100.0, 102.0)
    ros.until(lambda: 101.5 * NANOSECONDS < odom.latest_stamp < 102.1 * NANOSECONDS, 'odom anew')
    for name in chain:
        diagnostics.until(name, lambda s: figures(s).get('RestartError') == '1', 'one restart')
    for node in nodes:
        assert 'Traceback' not in node.stderr
