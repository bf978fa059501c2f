"""An accelerometer of the kernel on a tree of files: set, verified, read, lost, found again."""

import errno
import time
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from iio_tree import GRAVITY, SCALE, IioTree

from dead_reckoning.core.errors import (
    BusyDeviceError,
    DevicePermissionError,
    LostDeviceError,
    MissingDeviceError,
    RefusedSettingError,
    WrongDeviceError,
)
from dead_reckoning.core.front_end import Conversions
from dead_reckoning.sources.devices import Opened
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.iio.device import Iio
from dead_reckoning.sources.iio.settings import IioSettings

MODEL = DriverSettings(sensor='adxl345', range_g=16.0).model()


@pytest.fixture
def tree(tmp_path):
    """Give a tree with the device plugged in."""
    tree = IioTree(tmp_path).plug()
    yield tree
    tree.unplug()


@pytest.fixture
def bare(tmp_path):
    """Give a tree of a kernel whose driver has no buffer."""
    return IioTree(tmp_path, buffer=False).plug()


def session(tree, range_g=16.0, now_ns=time.time_ns, **settings):
    model = DriverSettings(sensor='adxl345', range_g=range_g).model()
    return Iio(IioSettings(root=str(tree.root), **settings), model, now_ns).session(time.sleep)


def conversions(events, count):
    """Return stamps and forces [m/s²] of the next so many samples."""
    taken, end = [], time.monotonic() + 10.0
    while sum(map(len, taken)) < count:
        assert time.monotonic() < end
        event = next(events)
        if event is not None:
            assert isinstance(event, Conversions), event
            taken.append(event)
    stamps = np.concatenate([event.stamps_ns for event in taken])
    counts = np.concatenate([event.counts for event in taken])
    return stamps, MODEL.force(counts, np.zeros(3))


def patch_write(monkeypatch, ending, result):
    """Let writes to files of this name fail, or store something else."""
    write_text = Path.write_text

    def patched(path, text):
        if not str(path).endswith(ending):
            return write_text(path, text)
        if isinstance(result, int):
            raise OSError(result, 'refused', str(path))
        return write_text(path, result)

    monkeypatch.setattr(Path, 'write_text', patched)


# The buffer -------------------------------------------------------------------------------------


def test_the_buffer_is_set_up_and_closed(tree):
    events = session(tree, rate=200.0, buffer_length=64)
    assert next(events) == Opened()
    assert tree.text('in_accel_sampling_frequency') == '200'
    assert tree.text('buffer/length') == '64'
    assert tree.enabled
    enabled = {p.name: p.read_text().strip() for p in tree.folder.glob('scan_elements/*_en')}
    assert enabled == {
        **{f'in_accel_{axis}_en': '1' for axis in 'xyz'},
        'in_timestamp_en': '1',
        'in_temp_en': '0',
    }
    events.close()
    assert not tree.enabled


def test_scans_become_forces_with_the_stamps_of_the_kernel(tree):
    events = session(tree)
    next(events)
    begun = time.time_ns()
    first, second = tree.scan(0, -128, 256, begun), tree.scan(-4095, 1, 2, begun + 10_000_000)
    tree.send(first + second[:5])  # a pipe may cut what the kernel does not
    stamps, forces = conversions(events, 1)
    tree.send(second[5:])
    more = conversions(events, 1)
    assert [*stamps, *more[0]] == [begun, begun + 10_000_000]
    assert forces[0] == pytest.approx([0.0, -0.5 * GRAVITY, GRAVITY], abs=1e-4)
    assert more[1][0] == pytest.approx([-4095 * SCALE, SCALE, 2 * SCALE], abs=1e-3)


def test_stamps_of_a_clock_that_can_not_be_changed_become_those_of_the_wall(tree, monkeypatch):
    (tree.folder / 'current_timestamp_clock').write_text('monotonic\n')
    patch_write(monkeypatch, 'current_timestamp_clock', errno.EINVAL)
    events = session(tree)
    next(events)
    tree.send(tree.scan(0, 0, 256, time.monotonic_ns()))
    stamps, _ = conversions(events, 1)
    assert stamps[0] == pytest.approx(time.time_ns(), abs=1e9)


def test_the_clock_is_set_to_the_wall(tree):
    (tree.folder / 'current_timestamp_clock').write_text('monotonic\n')
    next(session(tree))
    assert tree.text('current_timestamp_clock') == 'realtime'


def test_under_simulated_time_the_arrival_counts(tree):
    events = session(tree, now_ns=lambda: 1_000_000_000_000)
    next(events)
    tree.send(tree.scan(0, 0, 256, time.time_ns()))
    stamps, _ = conversions(events, 1)
    assert stamps[0] == pytest.approx(1_000_000_000_000, abs=1e8)


def test_samples_that_waited_in_the_sensor_and_came_with_one_stamp_are_spread(tree):
    events = session(tree)
    next(events)
    stamps = []
    for _ in range(4):
        now = time.time_ns()
        tree.send(tree.scan(0, 0, 256, now) * 8)
        stamps += list(conversions(events, 8)[0])
        time.sleep(0.08)
    assert np.all(np.diff(stamps) > 0)
    assert abs(now - stamps[-1]) <= 20_000_000
    np.testing.assert_allclose(np.diff(stamps[8:]), 10e6, rtol=0.3)


def test_a_device_without_stamps_is_stamped_at_arrival(tree):
    for path in tree.folder.glob('scan_elements/in_timestamp*'):
        path.unlink()
    events = session(tree)
    next(events)
    tree.send(tree.scan(0, 0, 256))
    stamps, forces = conversions(events, 1)
    assert stamps[0] == pytest.approx(time.time_ns(), abs=1e9)
    assert forces[0, 2] == pytest.approx(GRAVITY, abs=1e-4)


def test_an_unplugged_device_is_lost_and_found_again(tree):
    events = session(tree)
    next(events)
    tree.unplug()
    with pytest.raises(LostDeviceError, match='gone'):
        list(islice(events, 20))
    with pytest.raises(MissingDeviceError, match=r"no device 'adxl345', but none"):
        next(session(tree))
    tree.plug()
    assert next(session(tree)) == Opened()


def test_devices_that_are_unplugged_leave_no_descriptor(tmp_path):
    tree = IioTree(tmp_path)
    for cycle in range(50):
        tree.plug()
        events = session(tree)
        next(events)
        tree.unplug()
        with pytest.raises(LostDeviceError):
            list(islice(events, 3))
        if cycle == 0:
            before = len(list(Path('/proc/self/fd').iterdir()))
    assert len(list(Path('/proc/self/fd').iterdir())) == before


# What is set and verified -----------------------------------------------------------------------


def test_a_rate_that_is_refused_names_those_there_are(tree, monkeypatch):
    patch_write(monkeypatch, 'sampling_frequency', errno.EINVAL)
    with pytest.raises(RefusedSettingError, match=r'driver.iio.rate to one of 25, 50, 100'):
        next(session(tree, rate=90.0))
    assert not tree.enabled


def test_rates_that_are_listed_for_the_whole_device_count_too(bare, monkeypatch):
    """As by the ADXL345's driver in the kernels without its buffer."""
    name = 'sampling_frequency_available'
    (bare.folder / f'in_accel_{name}').rename(bare.folder / name)
    (bare.folder / name).write_text('0.09765625 50 100')
    next(session(bare, rate=0.0977))
    assert bare.text('in_accel_sampling_frequency') == '0.09765625'
    patch_write(monkeypatch, 'sampling_frequency', errno.EINVAL)
    with pytest.raises(RefusedSettingError, match=r'one of 0.09765625, 50, 100$'):
        next(session(bare, rate=90.0))


def test_a_rate_is_written_as_the_device_writes_it(tree):
    """The kernel compares: 0.09765625 is none of the rates of its ADXL345, 0.097 is."""
    offers = '0.097000 12.500000 100.000000'
    (tree.folder / 'in_accel_sampling_frequency_available').write_text(offers)
    next(session(tree, rate=12.5))
    assert tree.text('in_accel_sampling_frequency') == '12.500000'
    next(session(tree, rate=0.09765625))
    assert tree.text('in_accel_sampling_frequency') == '0.097000'


def test_a_rate_that_is_rounded_is_no_other_rate_unnoticed(tree, monkeypatch):
    patch_write(monkeypatch, 'sampling_frequency', '100.000000')
    with pytest.raises(RefusedSettingError, match='is 100 after 90 was written'):
        next(session(tree, rate=90.0))
    next(session(tree, rate=100.0))


def test_the_range_is_set_by_its_scale(tree):
    scales = '0.004789 0.009578 0.019156 0.038312'
    (tree.folder / 'in_accel_scale_available').write_text(scales)
    next(session(tree, range_g=4.0))
    assert tree.text('in_accel_scale') == '0.009578'


def test_a_range_that_stays_as_it_was_is_named(tree, monkeypatch):
    (tree.folder / 'in_accel_scale_available').write_text('0.004789 0.038312')
    patch_write(monkeypatch, 'in_accel_scale', '0.038312')
    with pytest.raises(RefusedSettingError, match=r'±16 g, not 2; set driver.range_g'):
        next(session(tree, range_g=2.0))


def test_a_range_that_is_not_there_is_named_with_those_that_are(tree):
    with pytest.raises(RefusedSettingError, match=r'±16 g, not 8; .* its ranges, 16 g'):
        next(session(tree, range_g=8.0))


def test_the_scale_can_be_overridden(tree):
    """In full resolution a count is 3.9 mg at ±2 g too, whatever the kernel says."""
    (tree.folder / 'in_accel_scale').write_text('0.004789')
    events = session(tree, range_g=2.0, scale=0.0383)
    next(events)
    tree.send(tree.scan(0, 0, 256, time.time_ns()))
    _, forces = conversions(events, 1)
    assert forces[0, 2] == pytest.approx(9.8, abs=0.01)


def test_offsets_of_the_kernel_are_added_before_the_scale(tree):
    (tree.folder / 'in_accel_z_offset').write_text('-10')
    events = session(tree)
    next(events)
    tree.send(tree.scan(0, 0, 266, time.time_ns()))
    _, forces = conversions(events, 1)
    assert forces[0] == pytest.approx([0.0, 0.0, GRAVITY], abs=1e-4)


def test_the_trigger_is_set(tree):
    (tree.folder / 'trigger').mkdir()
    (tree.folder / 'trigger/current_trigger').write_text('')
    next(session(tree, trigger='hr0'))
    assert tree.text('trigger/current_trigger') == 'hr0'


def test_a_timer_that_starts_the_conversions_has_the_rate(tree):
    (tree.folder / 'in_accel_sampling_frequency').unlink()
    (tree.folder / 'trigger').mkdir()
    (tree.folder / 'trigger/current_trigger').write_text('hr0\n')
    for number, name in enumerate(['other', 'hr0']):
        folder = tree.folder.parent / f'trigger{number}'
        folder.mkdir()
        (folder / 'name').write_text(f'{name}\n')
        (folder / 'sampling_frequency').write_text('100.000\n')
    next(session(tree, rate=200.0))
    assert (tree.folder.parent / 'trigger1/sampling_frequency').read_text() == '200'
    assert (tree.folder.parent / 'trigger0/sampling_frequency').read_text() == '100.000\n'


def test_a_buffer_that_can_not_be_enabled_points_to_the_trigger(tree, monkeypatch):
    write_text = Path.write_text

    def patched(path, text):
        if path.name == 'enable' and text == '1':
            raise OSError(errno.EINVAL, 'Invalid argument', str(path))
        return write_text(path, text)

    monkeypatch.setattr(Path, 'write_text', patched)
    with pytest.raises(RefusedSettingError, match=r'driver.iio.trigger'):
        next(session(tree))


@pytest.mark.parametrize(
    ('number', 'error', 'named'),
    [
        (errno.EACCES, DevicePermissionError, '99-dead-reckoning.rules'),
        (errno.EBUSY, BusyDeviceError, 'fuser'),
        (errno.ENODEV, LostDeviceError, 'gone'),
    ],
)
def test_failures_of_the_system_are_named(tree, monkeypatch, number, error, named):
    patch_write(monkeypatch, 'sampling_frequency', number)
    with pytest.raises(error, match=named):
        next(session(tree))


def test_what_is_no_accelerometer_of_three_axes_is_refused(tree):
    (tree.folder / 'scan_elements/in_accel_z_en').unlink()
    with pytest.raises(WrongDeviceError, match='in_accel_z'):
        next(session(tree))


# Which device -----------------------------------------------------------------------------------


def test_of_two_with_one_name_the_number_chooses(tree, tmp_path):
    other = IioTree(tmp_path, number=3).plug()
    with pytest.raises(MissingDeviceError, match=r'several.*iio:device0.*iio:device3'):
        next(session(tree))
    events = session(tree, device='3')
    next(events)
    assert other.enabled
    assert not tree.enabled
    events.close()
    other.unplug()


def test_a_device_of_another_name_is_listed(tree):
    with pytest.raises(
        MissingDeviceError, match=r"no device 'bmi160', but iio:device0 \(adxl345\)"
    ):
        next(session(tree, device='bmi160'))


# One file an axis -------------------------------------------------------------------------------


def test_without_a_buffer_the_axes_are_read_one_by_one_and_that_is_said(bare):
    events = session(bare, rate=50.0)
    opened = next(events)
    assert 'not one sample' in opened.notice
    assert 'does not tell its range' in opened.notice
    begun = time.time_ns()
    stamps, forces = conversions(events, 20)
    assert forces[-1] == pytest.approx([0.0, -0.5 * GRAVITY, GRAVITY], abs=1e-3)
    assert 0 <= stamps[0] - begun < 1e9
    assert np.mean(np.diff(stamps)) == pytest.approx(20e6, rel=0.2)


def test_a_buffer_is_left_alone_where_asked(tree):
    events = session(tree, buffered=False)
    assert 'not one sample' in next(events).notice
    conversions(events, 2)
    assert not tree.enabled


def test_a_device_lost_while_read_one_by_one(bare):
    events = session(bare)
    next(events)
    conversions(events, 2)
    bare.unplug()
    with pytest.raises(LostDeviceError):
        list(islice(events, 20))
