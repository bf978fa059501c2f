"""From counts to samples: averages, stamps, calibration, and no trace of how calls were cut."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dead_reckoning.core.accelerometer import Accelerometer
from dead_reckoning.core.errors import CalibrationError, NotAtRestError, SupersededError
from dead_reckoning.core.front_end import Conversions, FrontEnd
from dead_reckoning.core.gyroscope import Gyroscope
from dead_reckoning.core.rest import GRAVITY

RATE = 6400.0
START_NS = 1_700_000_000_000_000_000
MODEL = Accelerometer(
    range_g=1.5,
    zero_g=(1.65, 1.65, 1.65),
    sensitivity=(0.8, 0.8, 0.8),
    zero_g_tolerance=0.165,
    swing=(0.25, 3.05),
    noise=0.0047,
    unit_per_count=3.3 / 4096,
    limits=(0.0, 4095.0),
)
GYROSCOPE = Gyroscope(range=3.0, noise=0.1, resolution=0.01)
OFFSET = np.array([0.3, -0.2, 0.4])
UP = np.array([0.0, 0.0, GRAVITY])


def front_end(**kwargs):
    settings = {
        'frame_id': 'imu_link',
        'samples_per_message': 64,
        'calibration_samples': 1024,
        'rest_deviation': 0.5,
        'calibrate_on_start': False,
    }
    return FrontEnd(MODEL, **(settings | kwargs))


def conversions(count, force=(0.0, 0.0, GRAVITY), seed=1):
    """Return conversions of a sensor with OFFSET that measures a force, shape (3,) or (n, 3)."""
    random = np.random.default_rng(seed)
    force = np.broadcast_to(force, (count, 3))
    volts = MODEL.output(force + OFFSET) + MODEL.noise * random.standard_normal((count, 3))
    stamps_ns = START_NS + np.round(np.arange(count) / RATE * 1e9).astype(np.int64)
    return Conversions(stamps_ns, MODEL.counts(volts))


def turned(whole, seed=2):
    """Return the conversions with readings of a gyroscope beside them, some at its range."""
    rates = np.random.default_rng(seed).normal(0.0, 1.0, whole.counts.shape)
    return Conversions(whole.stamps_ns, whole.counts, GYROSCOPE.reading(rates))


def part(whole, start, stop):
    return whole.part(start, stop)


def moving(count):
    time = np.arange(count) / RATE
    return np.outer(np.sin(2.0 * np.pi * time / 0.2), [3.0, 0.0, 0.0]) + UP


def plain(samples):
    return [
        (
            sample.stamp_ns,
            sample.specific_force,
            sample.specific_force_covariance,
            sample.angular_velocity,
            sample.angular_velocity_covariance,
        )
        for sample in samples
    ]


def test_sample_is_the_mean_of_its_conversions():
    whole = conversions(128)
    first, second = front_end().add(whole)
    for sample, counts in ((first, whole.counts[:64]), (second, whole.counts[64:])):
        expected = MODEL.force(counts.mean(axis=0), np.array(MODEL.zero_g))
        assert sample.specific_force == pytest.approx(expected)
        assert sample.frame_id == 'imu_link'
        assert sample.orientation is None
        assert sample.angular_velocity is None


def test_stamp_is_the_middle_of_the_block():
    """64 conversions at 6400 Hz: from 0 to 63/6400 s."""
    first, second = front_end().add(conversions(128))
    assert first.stamp_ns - START_NS == round(31.5 / RATE * 1e9)
    assert second.stamp_ns - first.stamp_ns == 10_000_000


def test_one_conversion_is_its_own_sample():
    whole = conversions(5)
    samples = front_end(samples_per_message=1).add(whole)
    assert [sample.stamp_ns for sample in samples] == whole.stamps_ns.tolist()


def test_conversions_before_and_after_an_interruption_are_not_averaged_together():
    end, whole = front_end(samples_per_message=4), conversions(11)
    assert end.add(whole.part(0, 3)) == []
    end.interrupt()
    samples = end.add(whole.part(3))
    alone = front_end(samples_per_message=4).add(whole.part(3))
    assert len(samples) == 2
    assert plain(samples) == plain(alone)


def test_covariance_is_that_of_the_mean():
    (sample,) = front_end().add(conversions(64))
    x, y, z = MODEL.variance(64)
    assert sample.specific_force_covariance == (x, 0, 0, 0, y, 0, 0, 0, z)


def test_clipped_conversions_are_counted_and_show_in_the_covariance():
    force = np.tile([0.0, 0.0, GRAVITY], (128, 1))
    force[70:80, 0] = 3.0 * GRAVITY
    force[75:85, 1] = -3.0 * GRAVITY
    device = front_end()
    clean, clipped = device.add(conversions(128, force))
    assert device.clipped == 15
    x, y, z = clipped.specific_force_covariance[::4]
    assert (x, y) == pytest.approx(((1.5 * GRAVITY) ** 2,) * 2)
    assert z == clean.specific_force_covariance[8] == pytest.approx(MODEL.variance(64)[2])


def test_rate_is_the_mean_of_its_readings():
    whole = turned(conversions(128))
    samples = front_end(gyroscope=GYROSCOPE).add(whole)
    for sample, rates in zip(samples, (whole.rates[:64], whole.rates[64:]), strict=True):
        assert sample.angular_velocity == pytest.approx(rates.mean(axis=0))


def test_saturated_readings_are_counted_and_show_on_their_axis():
    whole = conversions(128)
    rates = np.zeros((128, 3))
    rates[70:80, 0] = GYROSCOPE.range
    rates[75:85, 1] = -GYROSCOPE.range
    device = front_end(gyroscope=GYROSCOPE)
    clean, saturated = device.add(Conversions(whole.stamps_ns, whole.counts, rates))
    assert (device.saturated, device.clipped) == (15, 0)
    usual = GYROSCOPE.variance(64)
    assert clean.angular_velocity_covariance == (usual, 0, 0, 0, usual, 0, 0, 0, usual)
    assert saturated.angular_velocity_covariance == (9.0, 0, 0, 0, 9.0, 0, 0, 0, usual)
    assert saturated.specific_force_covariance == clean.specific_force_covariance


def test_a_device_without_a_gyroscope_gives_no_rate():
    (sample,) = front_end(gyroscope=GYROSCOPE).add(conversions(64))
    assert sample.angular_velocity is None
    (sample,) = front_end().add(turned(conversions(64)))
    assert sample.angular_velocity is None


def oriented(whole, seed=3):
    """Return the conversions with orientations beside them."""
    orientations = np.random.default_rng(seed).normal(0.0, 1.0, (len(whole), 4))
    return Conversions(whole.stamps_ns, whole.counts, None, orientations)


def test_orientation_is_that_of_the_middle_conversion_with_its_covariance():
    covariance = (1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0)
    whole = oriented(conversions(128))
    whole.orientations[96] = np.nan
    first, second = front_end(orientation_covariance=covariance).add(whole)
    assert first.orientation == tuple(whole.orientations[32])
    assert first.orientation_covariance == covariance
    assert second.orientation is None


@given(st.lists(st.integers(1, 40), min_size=1, max_size=20))
def test_however_rates_and_orientations_come_and_go_cuts_do_not_matter(lengths):
    """Every second part has none of them: as NaN in one call, as None in calls of their own."""
    ends = np.cumsum(lengths)
    both = turned(conversions(ends[-1]))
    orientations = oriented(both).orientations
    whole = Conversions(both.stamps_ns, both.counts, both.rates, orientations)
    device = front_end(gyroscope=GYROSCOPE, samples_per_message=7)
    cut = []
    for number, (start, end) in enumerate(zip(ends - lengths, ends, strict=True)):
        part = whole.part(start, end)
        if number % 2:
            whole.rates[start:end] = whole.orientations[start:end] = np.nan
            part = Conversions(part.stamps_ns, part.counts)
        cut += device.add(part)
    at_once = front_end(gyroscope=GYROSCOPE, samples_per_message=7).add(whole)
    assert plain(cut) == plain(at_once)
    assert [s.orientation for s in cut] == [s.orientation for s in at_once]


def test_calibration_at_the_start_is_silent_and_takes_the_offsets_out():
    device = front_end(calibrate_on_start=True)
    assert device.add(conversions(1023)) == []
    samples = device.add(part(conversions(1024 + 640), 1023, 1024 + 640))
    assert len(samples) == 10
    assert samples[0].stamp_ns == START_NS + round((1024 + 31.5) / RATE * 1e9)
    assert device.finding is None
    mean = np.mean([sample.specific_force for sample in samples], axis=0)
    assert mean == pytest.approx([0.0, 0.0, GRAVITY], abs=0.02)


def test_without_calibration_the_offsets_show():
    mean = np.mean([s.specific_force for s in front_end().add(conversions(6400))], axis=0)
    assert mean == pytest.approx(OFFSET + UP, abs=0.01)


@pytest.mark.parametrize(
    ('force', 'error'),
    [(moving(1024), NotAtRestError), ((5.0, 0.0, GRAVITY), CalibrationError)],
)
def test_failure_at_the_start_is_said_and_samples_come_all_the_same(force, error):
    device = front_end(calibrate_on_start=True)
    assert device.add(conversions(1024, force)) == []
    assert isinstance(device.finding, error)
    (sample,) = device.add(part(conversions(1024 + 64), 1024, 1024 + 64))
    assert sample.specific_force == pytest.approx(OFFSET + UP, abs=0.05)
    np.testing.assert_array_equal(device.zero_g, MODEL.zero_g)


@pytest.mark.parametrize('started', [False, True])
def test_calibration_on_demand_keeps_the_samples_coming(started):
    device = front_end(calibrate_on_start=started)
    if started:
        device.add(conversions(1024))
    future = device.calibrate()
    samples = device.add(conversions(1023))
    assert len(samples) == 15
    assert not future.done()
    device.add(part(conversions(1024), 1023, 1024))
    assert future.result(timeout=0).startswith('offset of x, y, z: +0.03')
    off = (device.zero_g - MODEL.zero_g) / MODEL.sensitivity * GRAVITY
    assert off == pytest.approx(OFFSET, abs=0.01)


@pytest.mark.parametrize(
    ('force', 'error'),
    [(moving(1024), NotAtRestError), ((5.0, 0.0, GRAVITY), CalibrationError)],
)
def test_calibration_on_demand_that_fails_leaves_the_offsets(force, error):
    device = front_end(calibrate_on_start=True)
    device.add(conversions(1024))
    before = device.zero_g.copy()
    future = device.calibrate()
    device.add(conversions(1024, force))
    assert isinstance(future.exception(timeout=0), error)
    assert device.finding is None, 'who asked was told'
    np.testing.assert_array_equal(device.zero_g, before)


def test_asking_again_starts_over():
    device = front_end()
    first = device.calibrate()
    device.add(conversions(1000, moving(1000)))
    second = device.calibrate()
    assert isinstance(first.exception(timeout=0), SupersededError)
    device.add(conversions(1024))
    assert second.result(timeout=0).startswith('offset of')


cuts = st.lists(st.integers(0, 3000), max_size=12).map(sorted)


@settings(max_examples=30)
@given(cuts, st.sampled_from([1, 7, 64]), st.booleans(), st.booleans())
def test_cutting_the_conversions_changes_nothing(cuts, per_message, calibrate, still):
    whole = turned(conversions(3000, (0.0, 0.0, GRAVITY) if still else moving(3000)))
    kwargs = {
        'samples_per_message': per_message,
        'calibrate_on_start': calibrate,
        'gyroscope': GYROSCOPE,
    }
    together = front_end(**kwargs)
    expected = plain(together.add(whole))
    assert len(expected) == (3000 - 1024 * calibrate) // per_message
    cut = front_end(**kwargs)
    samples = []
    for start, stop in zip([0, *cuts], [*cuts, 3000], strict=True):
        samples += cut.add(part(whole, start, stop))
    assert plain(samples) == expected
    assert str(cut.finding) == str(together.finding)
    assert cut.saturated == together.saturated


@settings(max_examples=30)
@given(cuts)
def test_cutting_changes_nothing_while_a_calibration_runs(cuts):
    whole = conversions(3000)
    together, cut = front_end(), front_end()
    together.calibrate()
    cut.calibrate()
    samples = []
    for start, stop in zip([0, *cuts], [*cuts, 3000], strict=True):
        samples += cut.add(part(whole, start, stop))
    assert plain(samples) == plain(together.add(whole))
    np.testing.assert_array_equal(cut.zero_g, together.zero_g)
