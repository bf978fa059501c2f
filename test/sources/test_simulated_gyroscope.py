"""A simulated gyroscope: the true rate, and the faults it was given."""

import numpy as np
import pytest

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.sources.driver import simulated_sensor
from dead_reckoning.sources.simulated_gyroscope import GyroSettings, SimulatedGyroscope

RATE = 400.0
PERFECT = {
    'noise': 0.0,
    'bias': (0.0, 0.0, 0.0),
    'bias_walk': 0.0,
    'scale_error': (0.0, 0.0, 0.0),
    'resolution': 0.0,
}


def gyroscope(rate=RATE, seed=1, **settings):
    settings = GyroSettings(enabled=True, **(PERFECT | settings))
    return SimulatedGyroscope(settings, settings.model(rate), rate, seed)


def turning(count=2000):
    time = np.arange(count) / RATE
    return np.column_stack([np.sin(time), np.cos(2.0 * time), 3.0 * np.sin(3.0 * time)])


def test_perfect_one_reads_the_truth():
    np.testing.assert_array_equal(gyroscope().read(turning()), turning())


def test_scale_and_bias_are_as_set():
    read = gyroscope(scale_error=(0.01, -0.02, 0.0), bias=(0.1, 0.2, -0.3)).read(turning())
    expected = turning() * [1.01, 0.98, 1.0] + [0.1, 0.2, -0.3]
    np.testing.assert_allclose(read, expected, rtol=1e-12)


@pytest.mark.parametrize('rate', [100.0, 6400.0])
def test_noise_has_its_density_at_any_rate(rate):
    """One reading has density · √(rate/2); over one second the angle has density · √½."""
    density = 0.002
    read = gyroscope(rate, noise=density).read(np.zeros((640_000, 3)))
    assert read.std(axis=0) == pytest.approx([density * np.sqrt(rate / 2.0)] * 3, rel=0.01)
    second = int(rate)
    angle = read[: 640_000 // second * second].reshape(-1, second, 3).sum(axis=1) / rate
    assert angle.std() == pytest.approx(density * np.sqrt(0.5), rel=0.1)


def test_bias_walks_with_the_root_of_time():
    ends = {}
    for count in (400, 1600):
        read = [
            gyroscope(seed=s, bias_walk=0.01).read(np.zeros((count, 3)))[-1] for s in range(200)
        ]
        ends[count] = np.std(read)
    assert ends[400] == pytest.approx(0.01, rel=0.12)
    assert ends[1600] == pytest.approx(0.02, rel=0.12)


def test_it_rounds_and_ends_at_its_range():
    read = gyroscope(resolution=0.25, range=2.0).read(turning())
    np.testing.assert_array_equal(read, np.round(read * 4.0) / 4.0)
    assert np.abs(read[:, 2]).max() == 2.0
    assert np.abs(read[:, :2]).max() == 1.0


@pytest.mark.parametrize('cuts', [[1, 2, 3], [0, 64, 64, 999], list(range(0, 2000, 7))])
def test_cutting_the_readings_changes_nothing(cuts):
    faults = {'noise': 0.01, 'bias_walk': 0.01, 'bias': (0.1, 0.2, 0.3), 'resolution': 0.001}
    whole = gyroscope(**faults).read(turning())
    source = gyroscope(**faults)
    parts = [source.read(turning()[a:b]) for a, b in zip([0, *cuts], [*cuts, 2000], strict=True)]
    np.testing.assert_array_equal(np.concatenate(parts), whole)


def test_seed_decides_the_noise():
    first, again, other = (gyroscope(seed=seed, noise=0.01).read(turning()) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


def test_noise_is_one_sigma_of_a_reading_in_the_model():
    assert GyroSettings().model(RATE) is None, 'off by default'
    model = GyroSettings(enabled=True, noise=0.002).model(200.0)
    assert model.noise == pytest.approx(0.02)
    assert model.range == pytest.approx(np.radians(2000.0))


@pytest.mark.parametrize(
    ('key', 'value'), [('range', 0.0), ('noise', -1.0), ('resolution', np.nan), ('bias', (0.0,))]
)
def test_what_no_gyroscope_is_is_refused(key, value):
    with pytest.raises(SettingsError, match=rf'driver\.gyro\.{key}'):
        GyroSettings(**{key: value})


def test_it_is_read_with_the_conversions_and_leaves_the_accelerometer_as_it_is():
    values = {'driver.motion': 'gait', 'driver.gait.start': 0.0}
    with_it, without = (
        simulated_sensor(Configuration({**values, 'driver.gyro.enabled': on}), 0).read(3000)
        for on in (True, False)
    )
    assert without.rates is None
    assert with_it.rates.shape == (3000, 3)
    np.testing.assert_array_equal(with_it.counts, without.counts)


def test_attitude_of_the_table_does_not_show_in_the_rate():
    level, tilted = (
        simulated_sensor(
            Configuration(
                {
                    'driver.motion': 'turntable',
                    'driver.gyro.enabled': True,
                    'driver.simulated.attitude': attitude,
                }
            ),
            0,
        ).read(30_000)
        for attitude in ((0.0, 0.0, 0.0), (0.3, 0.2, 0.1))
    )
    np.testing.assert_array_equal(level.rates, tilted.rates)
    assert np.median(level.rates[24_000:, 2]) == pytest.approx(np.pi / 2.0, rel=0.01)
