"""`dead-reckoning calibrate step-length`: simulated walks, and the constants behind them."""

import re
from functools import cache

import pytest
import yaml
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from dead_reckoning import wire
from dead_reckoning.configuration import Configuration
from dead_reckoning.core import step_lengths
from dead_reckoning.core.pedometer import Pedometer, PedometerSettings
from dead_reckoning.sources.driver import front_end, simulated_sensor
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.tools.main import main

START_NS = 1_700_000_000_000_000_000
STEPS = 20


@cache
def samples(cadence, length):
    """Return a simulated walk."""
    configuration = Configuration(
        {
            'driver.motion': 'walk',
            'driver.range_g': 4.0,
            'driver.walk.cadence': cadence,
            'driver.walk.step_length': length,
            'driver.walk.steps': STEPS,
        }
    )
    source = simulated_sensor(configuration, START_NS)
    seconds = 3.0 + STEPS / cadence + 6.0
    count = round(seconds * configuration[DriverSettings].sample_rate)
    return tuple(front_end(configuration).add(source.read(count)))


@pytest.fixture
def walked(tmp_path):
    """Write walks as tables; return their paths."""

    def write(*walks):
        paths = []
        for cadence, length in walks:
            lines = ['stamp_ns,ax,ay,az']
            lines += [
                ','.join(map(repr, (imu.stamp_ns, *imu.specific_force)))
                for imu in samples(cadence, length)
            ]
            paths.append(tmp_path / f'{cadence}-{length}.csv')
            paths[-1].write_text('\n'.join(lines) + '\n')
        return paths

    return write


@pytest.fixture
def run(tmp_path, capsys):
    """Run the command; return exit status, what it printed, and what it wrote."""
    output = tmp_path / 'found.yaml'

    def calibrate(*arguments):
        words = map(str, ('calibrate', 'step-length', *arguments, '--output', output))
        status = main(list(words))
        written = Configuration.load(output)[PedometerSettings] if output.exists() else None
        return status, capsys.readouterr(), written

    return calibrate


def fitted(printed):
    """Return the table of models as lists of words."""
    names = step_lengths.names()
    rows = [line.split() for line in printed.out.splitlines()]
    return {row[0]: row[1:] for row in rows if row and row[0] in names}


def test_equal_steps_are_constant_at_any_pace(run, walked):
    status, printed, written = run(
        *walked((1.3, 0.6), (1.8, 0.6), (2.2, 0.6)), '--distance', 0.6 * STEPS
    )
    assert status == 0
    assert (written.length_model, written.k) == ('constant', pytest.approx(0.6))
    table = fitted(printed)
    assert set(table) == set(step_lengths.names())
    assert table['constant'][:6] == ['0.6000', 'm', '0.0', '%', '0.0', '%']
    assert '← written' in ' '.join(table['constant'])
    assert 'written' not in ' '.join(table['kim'])


def test_steps_that_follow_the_cadence_are_found_too(run, walked, tmp_path):
    """L = k h √cadence, of a height that is no default."""
    k, height, cadences = 0.25, 1.9, (1.44, 1.69, 1.96)
    walks = [(cadence, k * height * cadence**0.5) for cadence in cadences]
    config = tmp_path / 'my.yaml'
    config.write_text('/**:\n  ros__parameters:\n    pedometer.height: 1.9\n')
    distances = [STEPS * length for _, length in walks]
    status, _, written = run(*walked(*walks), '--distance', *distances, '--config', config)
    assert status == 0
    assert (written.length_model, written.k) == ('cadence_height', pytest.approx(k, rel=0.01))
    assert written.height == height, 'k means nothing without it'


def test_models_that_are_alike_leave_it_as_it_is(run, walked):
    (path,) = walked((1.8, 0.7))
    status, printed, written = run(path, path, '--distance', 14)
    assert status == 0
    assert all('0.0' in row for row in fitted(printed).values())
    assert written.length_model == PedometerSettings().length_model


def test_a_single_walk_fits_the_configured_model_and_tells_no_error(run, walked, tmp_path):
    config = tmp_path / 'my.yaml'
    parameters = {
        'pedometer.length_model': 'kim',
        'pipeline.estimators': ['integrator'],
        'pipeline.log_csv': str(tmp_path / 'log.csv'),
    }
    config.write_text(yaml.safe_dump({'/**': {'ros__parameters': parameters}}))
    (path,) = walked((1.8, 0.7))
    status, printed, written = run(path, '--distance', 14, '--config', config)
    assert status == 0
    assert written.length_model == 'kim'
    assert fitted(printed)['kim'][3:5] == ['–', '–']
    assert 'takes two recordings' in printed.out
    assert not (tmp_path / 'log.csv').exists()


@pytest.mark.parametrize('model', step_lengths.names())
def test_k_is_that_of_the_service(run, walked, model):
    """The node calibrates one model on the way; both find the same."""
    parts = Configuration(
        {'pedometer.length_model': model, 'pedometer.calibration_distance': 14.0}
    )
    settings = parts[PedometerSettings]
    pedometer = Pedometer(settings, parts[settings.method_part])
    pedometer.begin_calibration()
    for imu in samples(1.8, 0.7):
        pedometer.update(imu)
    found = pedometer.end_calibration()
    status, printed, written = run(*walked((1.8, 0.7)), '--distance', 14, '--model', model)
    assert (status, written.length_model) == (0, model)
    assert written.k == pytest.approx(found.k, rel=1e-6)
    assert re.search(rf'14 m +{found.steps} +0\.700 m', printed.out)


def test_it_takes_bags_and_says_what_could_not_be_used(run, tmp_path):
    imus = list(samples(1.8, 0.7))
    imus[50] = imus[49]
    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics = [
            writer.add_connection(topic, 'sensor_msgs/msg/Imu', typestore=store)
            for topic in ('/left', '/right')
        ]
        for number, imu in enumerate(imus):
            for topic in topics:
                writer.write(topic, 10**9 + number, wire.encode_imu(imu))
    status, printed, _ = run(tmp_path / 'bag', '--distance', 14)
    assert status == 2
    assert 'name one with --imu' in printed.err
    status, printed, written = run(
        tmp_path / 'bag', '--distance', 14, '--imu', '/left', '--model', 'constant'
    )
    assert (status, written.k) == (0, pytest.approx(0.7))
    assert '1 × RepeatedStampError' in printed.err


def test_what_is_wrong_is_said_and_nothing_written(run, walked, tmp_path):
    walk, other = walked((1.8, 0.7), (1.3, 0.6))
    still = tmp_path / 'still.csv'
    still.write_text('\n'.join(walk.read_text().splitlines()[:150]) + '\n')
    config = tmp_path / 'wrong.yaml'
    config.write_text('/**:\n  ros__parameters:\n    pedometer.lenght_model: kim\n')
    for arguments, words in (
        ((walk, still, '--distance', 14), f'{still}: no steps in it'),
        ((walk, other, '--distance', 14, 12, 10), '3 of them for 2 recordings'),
        ((walk, '--distance', 1e6), 'is --distance in metres?'),
        ((tmp_path / 'missing.csv', '--distance', 14), 'missing.csv'),
        ((walk, '--distance', 14, '--config', config), "did you mean 'pedometer.length_model'?"),
        ((walk, '--distance', 14, '--config', tmp_path / 'none.yaml'), 'none.yaml'),
    ):
        status, printed, written = run(*arguments)
        assert (status, written, printed.out) == (2, None, '')
        assert words in printed.err


@pytest.mark.parametrize('distance', ['0', '-5', 'nan', 'far'])
def test_a_distance_is_a_number_above_zero(run, walked, distance, capsys):
    with pytest.raises(SystemExit) as ended:
        run(*walked((1.8, 0.7)), f'--distance={distance}')
    assert ended.value.code == 2
    assert '--distance' in capsys.readouterr().err


def test_a_folder_is_no_output(walked, tmp_path, capsys):
    (walk,) = walked((1.8, 0.7))
    words = ('calibrate', 'step-length', str(walk), '--distance', '14', '--output', str(tmp_path))
    assert main(list(words)) == 2
    assert 'a folder' in capsys.readouterr().err
