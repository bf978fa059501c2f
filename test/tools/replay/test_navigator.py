"""A foot's recording through the navigator: causal and smoothed states, strides, the report."""

import json
from dataclasses import replace

import numpy as np
import pytest
import yaml
from replay_recordings import without_covariance, write_bag, write_table
from rosbags.rosbag2 import Reader
from simulated_walks import measured, navigator, streamed, walk

from dead_reckoning import wire
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.compass import Compass, CompassSettings
from dead_reckoning.core.errors import InputError
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rotation import yaw_from_quaternion
from dead_reckoning.core.samples import IDENTITY_QUATERNION, UNKNOWN, ZERO, NavigationState
from dead_reckoning.core.smoother import Smoother
from dead_reckoning.core.stages import COMPASS, ODOMETRY, RAW
from dead_reckoning.sources.bags import BagWriter
from dead_reckoning.tables import ODOMETRY_COLUMNS, odometry_row
from dead_reckoning.tools.main import main
from dead_reckoning.tools.replay.run import Job, run

NAVIGATOR = {'pipeline.estimators': ('inertial_navigator',)}
LEVER_ARM = (0.05, -0.3, 0.2)


@pytest.fixture(scope='module')
def foot():
    return measured(walk(), seed=2).block()


def samples(block):
    return [block.sample(k) for k in range(len(block))]


def flow(taken):
    return [(RAW, sample) for sample in taken]


def job(path, folder, wanted=None, **settings):
    return Job(path, folder, Configuration(NAVIGATOR | settings), wanted)


def table(path):
    return np.genfromtxt(path, delimiter=',', names=True, dtype=None, encoding='ascii')


def check(path, states):
    found = table(path)
    assert found.dtype.names == ODOMETRY_COLUMNS
    expected = [odometry_row(states.sample(k)) for k in range(len(states))]
    assert found['stamp_ns'].tolist() == states.stamp_ns.tolist()
    np.testing.assert_allclose(
        np.array(found.tolist())[:, 1:], np.array(expected, float)[:, 1:], rtol=0.0, atol=1e-9
    )


def smoothed(taken):
    """Return what the navigator and its smoother give by themselves."""
    filtered = navigator()
    smoother = Smoother(filtered)
    states = streamed(filtered, taken)
    return states, StateBlock.join(list(smoother.blocks())[::-1]), filtered.strides


def test_aiding_of_a_bag_is_taken_and_its_faults_are_counted(tmp_path, capsys, foot):
    """The foot says it moves at the speed that wheels of the recording say."""
    wheels = '/wheels/odom'
    types = {'/imu/data_raw': ('sensor_msgs/msg/Imu', False), wheels: ('nav_msgs/msg/Odometry', 0)}
    writer = BagWriter(tmp_path / 'walk', types)
    encode = wire.odometry_encoder('odom', 'base_link')
    variances = (1e-4, 0.0, 0.0, 0.0, 1e-4, 0.0, 0.0, 0.0, 1e-4)
    for k, sample in enumerate(samples(foot)[:600]):
        writer.write('/imu/data_raw', k, wire.encode_imu(sample))
        if k >= 400 and k % 20 == 0:
            told = NavigationState(sample.stamp_ns, ZERO, (0.3, 0.0, 0.0), IDENTITY_QUATERNION)
            told = replace(told, velocity_covariance=UNKNOWN if k < 500 else variances)
            writer.write(wheels, k, encode(told))
    writer.close()
    config = tmp_path / 'config.yaml'
    settings = {'pipeline.estimators': ['inertial_navigator'], 'navigator.aiding_patience': 0.0}
    config.write_text(yaml.safe_dump({'/**': {'ros__parameters': settings}}))
    ends = []
    for number, remap in enumerate(([], ['-r', f'aiding/odom:={wheels}'])):
        out = tmp_path / str(number)
        arguments = [str(tmp_path / 'walk'), '--config', str(config), '--output', str(out)]
        assert main(['replay', *arguments, '--outputs', 'summary', *remap]) == 0
        summary = json.loads((out / 'summary.json').read_text())
        assert summary['samples'] == 600
        assert summary['dropped'].get('AidingError', 0) == (5 if remap else 0)
        ends.append(summary['end_position_m'])
    said = capsys.readouterr().err
    assert '5 × AidingError: aiding/odom: the covariance of the velocity is' in said
    assert np.linalg.norm(np.subtract(*ends)) > 0.01


def test_causal_and_smoothed_states_and_strides(tmp_path, foot):
    run(job(write_bag(tmp_path / 'walk', flow(samples(foot))), tmp_path / 'out'))
    states, smooth, strides = smoothed(foot)
    check(tmp_path / 'out/odometry.csv', states)
    check(tmp_path / 'out/smoothed.csv', smooth)
    assert len(smooth) == len(foot), 'the rest at the start is known in the end'
    summary = json.loads((tmp_path / 'out/summary.json').read_text())
    assert summary['strides'] == strides.count == 20
    assert summary['distance_m'] == pytest.approx(strides.distance, rel=1e-9)
    moved = np.linalg.norm(np.diff(states.position, axis=0), axis=1).sum()
    assert summary['path_length_m'] == pytest.approx(moved)
    assert moved > 1.02 * strides.distance  # a foot swings up and down
    assert summary['steps'] is None
    assert summary['stationary_fraction'] == pytest.approx(np.mean(states.stationary))
    report = (tmp_path / 'out/report.html').read_text()
    assert '20 strides' in report
    assert 'navigator.shoe.least' in report
    assert 'gravity.rest_duration' not in report
    with Reader(tmp_path / 'out/bag') as bag:
        counts = {c.topic: c.msgcount for c in bag.connections}
        assert set(counts) == {'/odom', '/stationary'}
        assert counts['/odom'] == len(states)
        times = [at for connection, at, _ in bag.messages() if connection.topic == '/odom']
    assert times == states.stamp_ns.tolist()


def test_a_table_gives_the_same(tmp_path, foot):
    lines = ['stamp_ns,ax,ay,az,gx,gy,gz']
    for stamp, force, rate in zip(
        foot.stamp_ns.tolist(),
        foot.specific_force.tolist(),
        foot.angular_velocity.tolist(),
        strict=True,
    ):
        lines.append(','.join(map(repr, (stamp, *force, *rate))))
    (tmp_path / 'walk.csv').write_text('\n'.join(lines) + '\n')
    run(job(tmp_path / 'walk.csv', tmp_path / 'out', ('smoothed', 'odometry')))
    states, smooth, _ = smoothed(foot)
    check(tmp_path / 'out/odometry.csv', states)
    check(tmp_path / 'out/smoothed.csv', smooth)


def test_a_smoothed_body_is_where_its_sensor_is_not(tmp_path, foot):
    """Twice the same walk, the stamps going back between: each begins at the origin."""
    taken = samples(foot)
    path = write_bag(tmp_path / 'walk', flow([*taken, *taken]))
    wanted = ('smoothed', 'odometry', 'summary')
    for name, values in (('on', {}), ('off', {'frames.mounting_translation': LEVER_ARM})):
        run(job(path, tmp_path / name, wanted, **values))
    on, off = (table(tmp_path / name / 'smoothed.csv') for name in ('on', 'off'))
    position = [np.column_stack([t[k] for k in ('px', 'py', 'pz')]) for t in (on, off)]
    turns = np.column_stack([on[k] for k in ('qx', 'qy', 'qz', 'qw')])
    arms = rotated(turns, LEVER_ARM)
    (second,) = np.flatnonzero(np.diff(on['stamp_ns']) < 0) + 1
    assert second == pytest.approx(len(taken), abs=10)
    for part in (slice(0, second), slice(second, None)):
        # As smoothed the tilt at the start is another, by a degree, than it was then.
        moved = position[1][part] - position[0][part]
        start = moved + arms[part]
        np.testing.assert_allclose(start, np.broadcast_to(start[0], start.shape), atol=1e-9)
        np.testing.assert_allclose(start[0], arms[part][0], atol=0.01)
        assert np.abs(moved).max() > 0.1
    causal = table(tmp_path / 'off/odometry.csv')
    assert np.hypot(causal['px'][-1] - off['px'][-1], causal['py'][-1] - off['py'][-1]) < 1e-3
    summary = json.loads((tmp_path / 'off/summary.json').read_text())
    assert summary['strides'] == 40


def rotated(turns, vector):
    """Return a vector turned by quaternions, shape (n, 4), as rows."""
    u, w = turns[:, :3], turns[:, 3:]
    v = np.broadcast_to(vector, u.shape)
    return v + 2.0 * np.cross(u, np.cross(u, v) + w * v)


def test_only_the_navigator_has_a_smoother(tmp_path, foot):
    path = write_bag(tmp_path / 'walk', flow(samples(foot)[:300]))
    values = {'pipeline.estimators': ('integrator',)}
    with pytest.raises(InputError, match=r'smoothed: nothing gives smoothed states .*inertial'):
        run(job(path, tmp_path / 'out', ('smoothed',), **values))
    run(job(path, tmp_path / 'out', **values))
    assert not (tmp_path / 'out/smoothed.csv').exists()


def test_without_a_gyro_it_is_said_and_all_are_dropped(tmp_path, foot):
    path = write_table(tmp_path / 'walk.csv', without_covariance(samples(foot)[:300]))
    result = run(job(path, tmp_path / 'out', ('summary', 'smoothed', 'odometry', 'report')))
    assert result.figures['dropped'] == {'MissingRateError': 300}
    assert result.figures['strides'] == 0
    assert result.figures['path_length_m'] is result.figures['end_position_m'] is None
    assert (tmp_path / 'out/smoothed.csv').read_text().count('\n') == 1


def test_a_compass_gives_the_yaw_as_it_does_live(tmp_path, foot):
    compass = Compass(CompassSettings(), 'compass_link')
    mixed = []
    for number, sample in enumerate(samples(foot)):
        mixed.append((RAW, sample))
        if number % 10 == 0:
            mixed.append((COMPASS, compass.sample(sample.stamp_ns + 1, 1.0 + 1e-5 * number)))
    run(job(write_bag(tmp_path / 'walk', mixed), tmp_path / 'out', ('odometry',)))
    chain = Pipeline(Configuration(NAVIGATOR)).chain
    outputs = [output for name, sample in mixed for output in chain.push(name, sample)]
    states = [state for name, state in [*outputs, *chain.end()] if name == ODOMETRY]
    check(tmp_path / 'out/odometry.csv', StateBlock.of(states))
    assert yaw_from_quaternion(states[0].attitude) == pytest.approx(np.pi / 2 - 1.0, abs=0.01)


def test_a_held_body_has_no_strides(tmp_path, foot):
    path = write_bag(tmp_path / 'walk', flow(samples(foot)))
    values = {'navigator.zero_velocity': False, 'navigator.gravity_direction': True}
    result = run(job(path, tmp_path / 'out', ('summary', 'odometry'), **values))
    way = table(tmp_path / 'out/odometry.csv')
    moved = np.linalg.norm(np.diff([way[k] for k in ('px', 'py', 'pz')]), axis=0).sum()
    assert result.figures['strides'] is result.figures['distance_m'] is None
    assert result.figures['path_length_m'] == pytest.approx(moved)


def test_the_rests_of_a_vehicle_are_no_stances(tmp_path, foot):
    path = write_bag(tmp_path / 'walk', flow(samples(foot)))
    result = run(job(path, tmp_path / 'out', ('summary',), **{'navigator.nonholonomic': True}))
    assert result.figures['strides'] is result.figures['distance_m'] is None
    assert result.figures['path_length_m'] > 1.0
    assert result.figures['stationary_fraction'] > 0.1
