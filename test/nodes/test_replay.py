"""One recording through `pipeline` over DDS and through `replay`: the same Odometry."""

import numpy as np
import pytest
from messages import GRAVITY, NANOSECONDS, START_NS, Feed, imu_message, realistic_samples
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from replays import odometry_of
from ros_harness import latest_taken, lossless, taken
from sensor_msgs.msg import Imu

from dead_reckoning.live import IntegratorChain

TOPICS = {'rest': 'imu/data_raw', 'message': 'imu/data'}
WARM_UP_NS = START_NS + 1_000 * NANOSECONDS
"""Stamps before the recording; the step back makes the node start anew."""


LEVER_ARM = {'frames.mounting_translation': [0.3, -0.1, 0.2]}

CASES = {
    'compiled': {
        'pipeline.estimators': ['integrator', 'pedometer'],
        'pedometer.input': 'imu/data',
    },
    'stream': LEVER_ARM,
    'kalman': {**LEVER_ARM, 'integrator.method': 'kalman'},
}


@pytest.mark.parametrize('attitude', TOPICS)
@pytest.mark.parametrize('case', CASES)
def test_live_and_replay_give_the_same_odometry(ros, tmp_path, attitude, case):
    topic = TOPICS[attitude]
    settings = {
        'gravity.attitude': attitude,
        'integrator.window_maximum': 0.07,
        **CASES[case],
    }
    if case == 'compiled':
        pytest.importorskip('numba')
        IntegratorChain.compile()  # so that it is kept, and the node finds it
    messages = [serialize_message(message) for message in realistic_samples()]

    ros.start('pipeline', {**settings, **lossless(f'/{topic}', '/odom')})
    live = ros.record('odom', Odometry, raw=True).connected()
    publisher = ros.publisher(topic, Imu)
    # Until the first output arrives, some may be lost: what counts comes after.
    warm_up = Feed(
        ros,
        lambda stamp_ns: publisher.publish(
            imu_message(stamp_ns, (0, 0, GRAVITY), (0, 0, 0, 1), 'sensor')
        ),
        start_ns=WARM_UP_NS,
    )
    warm_up.send_until(lambda: live.messages, 'odometry')
    said = ros.diagnostics()
    if case == 'compiled':
        warm_up.send_until(lambda: taken(said) > 0, 'compiled code')
    before = latest_taken(ros, said) if case == 'compiled' else 0
    for message in messages:
        publisher.publish(message)

    replayed = odometry_of(topic, messages, settings, tmp_path)

    assert len(replayed) > 300
    last = replayed[-1][:12]
    ros.until(lambda: live.messages[-1][:12] == last, 'the last odometry')
    doubles = 8 * 85
    published = live.messages[-len(replayed) :]
    assert [data[:-doubles] for data in published] == [data[:-doubles] for data in replayed]
    np.testing.assert_allclose(
        [np.frombuffer(data[-doubles:]) for data in replayed],
        [np.frombuffer(data[-doubles:]) for data in published],
        rtol=1e-9,
        atol=1e-9,
    )
    if case == 'compiled':
        assert latest_taken(ros, said) - before > 0.2 * len(messages)
