"""The benchmarks run on tiny stand-ins of the recordings, and find what was put into them."""

import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

from benchmarks.accuracy import broad, jackal
from benchmarks.accuracy.accounting import GRAVITY, INTEGRATOR, Live, account
from benchmarks.accuracy.drift import FREE, Truth, drifts, every
from benchmarks.accuracy.report import Report
from benchmarks.accuracy.signals import derivative, low_pass, second_derivative
from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.integrator import Integrator, IntegratorSettings
from dead_reckoning.core.samples import IDENTITY_QUATERNION, ImuSample, LinearAcceleration
from dead_reckoning.tools.table import table

ROOT = Path(__file__).parents[2]
GRAVITY_W = np.array([0.0, 0.0, 9.81])


def free_integrator():
    return Integrator(IntegratorSettings.from_values(FREE), CommonSettings())


def yaw_quaternions(yaw):
    zeros = np.zeros_like(yaw)
    return np.stack((zeros, zeros, np.sin(yaw / 2), np.cos(yaw / 2)), axis=1)


def turn_back(yaw, vector_w):
    """Take vectors, shape (n, 3), from the world into a frame turned by a yaw."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, y, z = vector_w.T
    return np.stack((c * x + s * y, c * y - s * x, z), axis=1)


def smooth_step(x):
    """Go from 0 to 1 with continuous curvature."""
    x = np.minimum(x, 1.0)
    return x**3 * (10.0 - 15.0 * x + 6.0 * x * x)


def write_broad(path, lever_arm, offset):
    """Write a trial that rests for 12 s and then swings and turns for 14 s; 100 Hz, one gap."""
    rate = 100.0
    time = np.arange(2600) / rate
    gone = np.maximum(time - 12.0, 0.0)
    ramp = smooth_step(gone)
    yaw = 0.4 * ramp * np.sin(1.3 * gone)
    swing = ramp[:, None] * np.sin(np.outer(gone, (2.0, 3.0, 2.5))) * 0.3
    lever_w = -turn_back(-yaw, np.tile(lever_arm, (len(time), 1)))  # from sensor to markers
    acceleration = np.gradient(np.gradient(swing, time, axis=0), time, axis=0)
    noise = np.random.default_rng(1).normal(0.0, 0.005, swing.shape)
    quaternions = yaw_quaternions(yaw)[:, [3, 0, 1, 2]]
    markers = swing + lever_w
    quaternions[1900:1905] = np.nan
    markers[1900:1905] = np.nan
    path.parent.mkdir(parents=True)
    np.savez(
        path,
        fs=rate,
        acc=turn_back(yaw, acceleration + GRAVITY_W) + offset + noise,
        gyr=np.stack((0 * yaw, 0 * yaw, np.gradient(yaw, time)), axis=1),
        mag_uT=np.zeros_like(swing),
        quat_wxyz_enu=quaternions,
        pos=markers,
        movement=gone > 0.0,
    )


def write_jackal(path):
    """Write a drive of 14 s at 50 Hz: rest, then a bend; one stamp comes twice."""
    store = get_typestore(Stores.ROS1_NOETIC)
    types = store.types
    numbers = np.arange(700)
    time = numbers / 50.0
    gone = np.maximum(time - 2.0, 0.0)
    speed = 1.0 - np.cos(np.minimum(gone, np.pi))
    yaw = 0.2 * gone
    velocity = np.stack((speed * np.cos(yaw), speed * np.sin(yaw), 0 * yaw), axis=1)
    force = turn_back(yaw, np.gradient(velocity, time, axis=0) + GRAVITY_W)
    force += np.random.default_rng(2).normal(0.0, 0.01, force.shape)
    quaternions = yaw_quaternions(yaw)

    def header(k):
        stamp = types['builtin_interfaces/msg/Time'](40 + k // 50, k % 50 * 20_000_000)
        return types['std_msgs/msg/Header'](k, stamp, 'base_link')

    def vector(x, y=0.0, z=0.0):
        return types['geometry_msgs/msg/Vector3'](x, y, z)

    def quaternion(k):
        return types['geometry_msgs/msg/Quaternion'](*quaternions[k])

    variances = np.diag([1e-6] * 3).ravel()

    def imu(k):
        return types['sensor_msgs/msg/Imu'](
            header(k),
            quaternion(k),
            variances,
            vector(0.0, 0.0, 0.2 if gone[k] > 0.0 else 0.0),
            variances,
            vector(*force[k]),
            variances,
        )

    def odometry(k):
        pose = types['geometry_msgs/msg/Pose'](
            types['geometry_msgs/msg/Point'](0.0, 0.0, 0.0), quaternion(k)
        )
        twist = types['geometry_msgs/msg/Twist'](vector(speed[k]), vector(0.0))
        return types['nav_msgs/msg/Odometry'](
            header(k),
            'base_link',
            types['geometry_msgs/msg/PoseWithCovariance'](pose, np.zeros(36)),
            types['geometry_msgs/msg/TwistWithCovariance'](twist, 1e-3 * np.eye(6).ravel()),
        )

    path.parent.mkdir(parents=True)
    recorded = {
        jackal.TOPIC: ('sensor_msgs/msg/Imu', imu, [*numbers[:300], 299, *numbers[300:]]),
        jackal.WHEELS: ('nav_msgs/msg/Odometry', odometry, numbers),
    }
    with Writer(path) as writer:
        for topic, (kind, make, order) in recorded.items():
            connection = writer.add_connection(topic, kind, typestore=store)
            for at, k in enumerate(order):
                message = store.serialize_ros1(make(int(k)), kind)
                writer.write(connection, at * 20_000_000, message)


def run(*arguments, domain=0):
    return subprocess.run(
        [sys.executable, '-m', 'benchmarks.accuracy', *map(str, arguments)],
        cwd=ROOT,
        env={**os.environ, 'ROS_DOMAIN_ID': str(domain)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_the_command_measures_what_is_there(tmp_path, domain_id):
    pytest.importorskip('rclpy')
    write_jackal(tmp_path / 'robot_bags' / 'jackal_small.bag')
    write_broad(tmp_path / 'broad' / 'small.npz', np.array([0.1, 0.0, 0.0]), 0.05)
    output = tmp_path / 'out'
    done = run(tmp_path, '--output', output, '--only', 'jackal', 'broad', domain=domain_id)
    assert done.returncode == 0, done.stdout + done.stderr
    assert 'unaccounted for' in done.stdout
    for name in ('jackal-jackal_small', 'broad-small'):
        assert (output / f'{name}.png').read_bytes().startswith(b'\x89PNG')
    figures = json.loads((output / 'accuracy.json').read_text())

    drive = figures['jackal-jackal_small']
    assert drive['messages']['published'] == drive['messages']['recorded'] == 701
    assert drive['messages']['accelerations'] == drive['messages']['odometries'] == 700
    repeated = {'RepeatedStampError': 1}
    assert drive['messages']['dropped'] == {GRAVITY: repeated, INTEGRATOR: repeated}
    assert not any(drive['messages']['unaccounted'].values())
    assert drive['equal_to_direct_chain']
    assert drive['aided_equal_to_direct_chain']
    aided = drive['aided']['vehicle.yaml, aided']
    assert aided['taken'] > 500 > 5 > aided['refused']
    # The last samples wait: navigator.look_ahead of the preset is 0.3 s, at 2 m/s.
    way = drive['drive']['wheel_distance_m'] - 0.3 * 2.0
    assert aided['way_m'] == pytest.approx(way, rel=0.01)
    assert drive['drift']['against the wheels']['2 s']['median_m'] < 0.02
    assert drive['drive']['integrated_distance_m'] == pytest.approx(
        drive['drive']['wheel_distance_m'], rel=0.05
    )

    trial = figures['broad-small']
    assert trial['recording']['dropped'] == {'MissingAttitudeError': 5}
    assert trial['lever_arm_m'] == pytest.approx((0.1, 0.0, 0.0), abs=2e-3)
    assert trial['delay_s'] == pytest.approx(0.0, abs=1e-3)
    errors = trial['acceleration_rmse']['in motion']
    assert errors['markers and delay fitted'] < 0.01 < errors['offset taken off']
    for runs in trial['drift'].values():
        assert runs['10 s']['starts'] >= 3
        assert runs['10 s']['median_m'] < 0.3


def test_nothing_there_is_an_error(tmp_path):
    done = run(tmp_path, '--output', tmp_path / 'out')
    assert done.returncode == 2
    assert done.stdout.count('skipped') == 12
    assert 'none of the recordings is there' in done.stderr


def test_a_broken_recording_is_a_fault(tmp_path):
    (tmp_path / 'broad').mkdir()
    np.savez(tmp_path / 'broad' / 'half.npz', fs=100.0)
    (tmp_path / 'robot_bags').mkdir()
    (tmp_path / 'robot_bags' / 'jackal_empty.bag').write_bytes(b'')
    done = run(tmp_path, '--output', tmp_path / 'out', '--only', 'jackal', 'broad')
    assert done.returncode == 1
    assert 'half.npz: no acc, gyr' in done.stderr
    assert 'jackal_empty.bag' in done.stderr
    assert 'Traceback' not in done.stderr


@pytest.mark.parametrize(
    ('lost', 'words'),
    [
        ({'published': 9}, 'published'),
        ({'accelerations': 8}, 'linear accelerations received'),
        ({'states': 6}, 'odometries received'),
        ({'taken': {GRAVITY: 9, INTEGRATOR: 19}}, f'taken in by {GRAVITY}'),
        ({'taken': {GRAVITY: 10, INTEGRATOR: 18}}, f'taken in by {INTEGRATOR}'),
    ],
)
def test_a_lost_message_is_a_fault(lost, words):
    """Of ten messages both nodes drop one, the integrator another; one more is lost."""
    whole = {
        'published': 10,
        'accelerations': 9,
        'states': 8,
        'taken': {GRAVITY: 10, INTEGRATOR: 19},
        'dropped': {
            GRAVITY: {'RepeatedStampError': 1},
            INTEGRATOR: {'RepeatedStampError': 1, 'NotFiniteError': 1},
        },
    }

    def faults_of(values):
        lists = {name: [None] * values[name] for name in ('accelerations', 'states')}
        report = Report('', '')
        account(report, 10, Live(**{**values, **lists}))
        return report.faults

    assert faults_of(whole) == []
    faults = faults_of({**whole, **lost})
    assert any(words in fault for fault in faults)


def test_other_numbers_than_the_direct_chain_are_a_fault():
    samples = [
        ImuSample(k * 10_000_000, 's', (0.0, 0.0, 9.8), orientation=IDENTITY_QUATERNION)
        for k in range(1, 100)
    ]
    report = Report('', '')
    nothing = SimpleNamespace(accelerations=[], states=[])
    jackal.compare_with_direct(report, samples, nothing)
    assert report.faults == ['the nodes and the chain called directly give different numbers']


def test_a_constant_error_drifts_by_half_its_square():
    """Error a: ½·a·T² away after T, whatever the velocity at the start is."""
    error, speed = 0.02, 3.0
    stamps = [round(k * 1e7) + 1 for k in range(1500)]
    pairs = [
        (
            LinearAcceleration(stamp_ns, 'odom', (0.0, error, 0.0)),
            ImuSample(stamp_ns, 's', (0.0, error, 9.8), orientation=IDENTITY_QUATERNION),
        )
        for stamp_ns in stamps
    ]
    time = np.arange(1500) * 0.01
    still = np.zeros(1500)
    truth = Truth(
        np.stack((speed * time, still, still), axis=1),
        np.stack((speed + still, still, still), axis=1),
    )
    starts = every(1.0, pairs, 0, 1499)
    assert starts == [0, 100, 200, 300, 400]
    measured = drifts(pairs, truth, starts, free_integrator())
    assert [drift.horizon for drift in measured] == [0.5 * k for k in range(1, 21)]
    for drift in measured:
        expected = np.tile((0.0, 0.5 * error * drift.horizon**2, 0.0), (5, 1))
        assert drift.error == pytest.approx(expected, abs=1e-6)


def test_what_is_not_known_is_left_out():
    pairs = [
        (
            LinearAcceleration(k * 10_000_000, 'odom', (0.0, 0.0, 0.0)),
            ImuSample(k * 10_000_000, 's', (0.0, 0.0, 9.8), orientation=IDENTITY_QUATERNION),
        )
        for k in range(1, 1302)
        if k != 701  # no sample 7 s after the first
    ]
    position, velocity = np.zeros((1300, 3)), np.zeros((1300, 3))
    position[200] = np.nan  # 2 s after the first
    velocity[100] = np.nan  # no second start
    measured = drifts(
        pairs,
        Truth(position, velocity),
        [0, 100, 250],
        free_integrator(),
    )
    count = {drift.horizon: len(drift.error) for drift in measured}
    assert count[1.0] == count[10.0] == 2
    assert count[2.0] == 1
    assert count[7.0] == 1


def test_the_low_pass_halves_the_power_at_its_cut_off():
    time = np.arange(4000) / 200.0
    for frequency, gain in ((0.0, 1.0), (5.0, 0.5**0.5), (20.0, 0.5**8)):
        wave = np.cos(2 * np.pi * frequency * time)[:, None]
        smooth = low_pass(wave, 200.0, 5.0)[1000:3000]
        assert smooth == pytest.approx(gain * wave[1000:3000], abs=1e-3)


def test_filters_leave_out_what_is_beside_a_gap():
    signal = np.ones((400, 1))
    signal[200] = np.nan
    smooth = low_pass(signal, 100.0, 5.0)
    known = ~np.isnan(smooth[:, 0])
    assert not known[200]
    assert not known[0]
    assert known[100]
    assert smooth[known] == pytest.approx(1.0)
    assert np.isnan(derivative(signal, 100.0)[[0, 199, 201, 399]]).all()
    assert np.isnan(low_pass(np.ones((5, 1)), 100.0, 5.0)).all()


def test_derivatives_of_a_parabola():
    time = np.arange(100)[:, None] / 50.0
    assert derivative(time**2, 50.0)[1:-1] == pytest.approx(2 * time[1:-1])
    assert second_derivative(time**2, 50.0)[1:-1] == pytest.approx(2.0, abs=1e-6)


def test_too_little_rest_is_an_error(tmp_path):
    write_broad(tmp_path / 'broad' / 'short.npz', np.zeros(3), 0.0)
    run_of_it = broad.run_chain(broad.load(tmp_path / 'broad' / 'short.npz'))
    with pytest.raises(RecordingError, match='too short to take the offset from 30 s'):
        broad.calibrate(tmp_path, run_of_it.pairs, 30.0)


def test_a_table_lines_up():
    text = table(('', 'a', 'bb'), [('one', '1', '22'), ('three', '333', '4')])
    assert text.splitlines() == ['           a  bb', '  one      1  22', '  three  333   4']
