"""An ADXL345 by its registers: set up in order, each sample once, stamped when converted."""

import errno
from itertools import islice

import numpy as np
import pytest
from models import Adxl345Model, BusModel, World

from dead_reckoning.core.errors import (
    DeviceError,
    DevicePermissionError,
    LostDeviceError,
    MissingDeviceError,
    OverrunError,
    RefusedSettingError,
    SettingsError,
    WrongDeviceError,
)
from dead_reckoning.core.front_end import Conversions
from dead_reckoning.sources.devices import Opened
from dead_reckoning.sources.i2c.adxl345 import Adxl345, I2cSettings


class Bench:
    """A driver on a model."""

    def __init__(self, range_g=16.0, transfer=200e-6, **settings):
        model = {key: settings.pop(key) for key in ('force', 'off') if key in settings}
        self.world = World(transfer)
        self.model = Adxl345Model(self.world, **model)
        self.bus = BusModel(self.world, self.model)
        self.sensor = Adxl345(I2cSettings(**settings), range_g, self.bus, self.world.now)

    def session(self, wait=None):
        return self.sensor.session(wait or self.world.wait)

    def conversions(self, looks):
        events = [event for event in islice(self.session(), looks) if event is not None]
        assert isinstance(events[0], Opened)
        assert all(isinstance(event, Conversions) for event in events[1:]), events
        stamps = np.concatenate([event.stamps_ns for event in events[1:]])
        return stamps, np.concatenate([event.counts for event in events[1:]])


def test_it_is_set_up_as_the_tutorial_does():
    bench = Bench(rate=3200.0, transfer=30e-6)
    session = bench.session()
    assert next(session) == Opened()
    registers = bench.model.registers
    assert registers[0x31] == 0x0B, 'full resolution, ±16 g'
    assert registers[0x2C] == 0x0F, '3200 Hz'
    assert registers[0x2D] == 0x08, 'it measures'
    assert registers[0x38] == 0x80, 'the FIFO holds the newest'
    session.close()
    assert bench.bus.opened == 0


@pytest.mark.parametrize(('range_g', 'code'), [(2.0, 0), (4.0, 1), (8.0, 2), (16.0, 3)])
def test_range(range_g, code):
    bench = Bench(range_g)
    next(bench.session())
    assert bench.model.registers[0x31] == 0x08 | code


@pytest.mark.parametrize(('rate', 'code'), [(0.09765625, 0), (12.5, 7), (100.0, 10), (800.0, 13)])
def test_rate(rate, code):
    bench = Bench(rate=rate)
    next(bench.session())
    assert bench.model.registers[0x2C] == code


def test_counts_are_little_endian_with_their_sign():
    bench = Bench(force=lambda _: (-1.0, 0.5, 15.9))
    _, counts = bench.conversions(20)
    assert counts == pytest.approx(np.tile([-256.0, 128.0, 4070.0], (len(counts), 1)))


def test_the_lowest_bit_is_zero_at_3200_hz():
    bench = Bench(rate=3200.0, transfer=30e-6, force=lambda _: (255 / 256, 0.0, 1.0))
    _, counts = bench.conversions(50)
    assert set(counts[:, 0]) == {254.0}


@pytest.mark.parametrize('rate', [25.0, 100.0, 800.0])
def test_every_sample_comes_once(rate):
    """The model gives none twice; that none is missing shows in the times of those read."""
    bench = Bench(rate=rate, transfer=100e-6)
    stamps, _ = bench.conversions(300)
    assert bench.model.overruns == 0
    assert len(stamps) == len(bench.model.times)
    np.testing.assert_allclose(np.diff(bench.model.times), 1e9 / rate, rtol=1e-3)


@pytest.mark.parametrize('off', [0.98, 1.0, 1.02])
@pytest.mark.parametrize('rate', [100.0, 800.0])
def test_stamps_are_those_of_the_conversions(rate, off):
    """Though the oscillator is off by 2 % and the looks come late by up to 10 ms."""
    bench = Bench(rate=rate, off=off, transfer=50e-6)
    random = np.random.default_rng(1)
    session = bench.session(lambda s: bench.world.wait(s + random.uniform(0.0, 0.01)))
    events = list(islice(session, 2000))[1:]
    stamps = np.concatenate([event.stamps_ns for event in events if event is not None])
    assert np.all(np.diff(stamps) > 0)
    late = (stamps - bench.model.times)[len(stamps) // 4 :] * 1e-9
    assert np.sqrt(np.mean(late**2)) < 0.1 / rate
    assert np.abs(late).max() < 0.5 / rate


def test_what_ran_over_is_said_and_stamps_go_on():
    bench = Bench(rate=800.0)
    session = bench.session()
    before = [next(session) for _ in range(10)][-1]
    bench.world.wait(0.5)
    overrun, after = next(session), next(session)
    assert isinstance(overrun, OverrunError)
    assert 'driver.i2c.rate' in str(overrun)
    assert len(after) == 33
    assert after.stamps_ns[0] - before.stamps_ns[-1] > 0.4e9
    assert after.stamps_ns[-1] == pytest.approx(bench.model.times[-1], abs=1.3e6)


def test_a_sensor_that_lost_its_supply_is_set_up_again():
    bench = Bench()
    session = bench.session()
    for _ in range(5):
        next(session)
    bench.model.reset()
    with pytest.raises(LostDeviceError, match='supply'):
        list(islice(session, 1000))
    assert bench.bus.opened == 0
    stamps, _ = bench.conversions(20)
    assert len(stamps) > 10


def test_an_unplugged_sensor_is_named_and_the_bus_closed():
    bench = Bench()
    session = bench.session()
    for _ in range(5):
        next(session)
    bench.bus.plugged = False
    with pytest.raises(MissingDeviceError, match=r'0x53.*i2cdetect -y 1'):
        next(session)
    assert bench.bus.opened == 0
    bench.bus.plugged = True
    assert next(bench.session()) == Opened()


@pytest.mark.parametrize(
    ('number', 'error', 'named'),
    [
        (errno.ENOENT, MissingDeviceError, 'i2c-dev'),
        (errno.EACCES, DevicePermissionError, 'usermod -aG i2c'),
        (errno.EMFILE, DeviceError, '/dev/i2c-1'),
    ],
)
def test_a_bus_that_can_not_be_opened(number, error, named):
    bench = Bench()
    bench.bus.failure = number
    with pytest.raises(error, match=named):
        next(bench.session())


def test_another_device_is_not_taken_for_it():
    bench = Bench()
    bench.model.registers[0x00] = 0x68
    with pytest.raises(WrongDeviceError, match=r'0xe5.*0x68'):
        next(bench.session())


def test_a_register_that_does_not_keep_what_is_written_is_named():
    bench = Bench()
    transfer = bench.model.transfer

    def forgetful(written, count):
        return transfer(written if written[0] != 0x31 else written[:1] + bytes(1), count)

    def reads(written, count):
        return transfer(written, count) if count else forgetful(written, count)

    bench.model.transfer = reads
    with pytest.raises(RefusedSettingError, match=r'0x31 holds 0x00 after 0x0b'):
        next(bench.session())


def test_a_rate_it_does_not_have_is_refused_with_the_nearest():
    with pytest.raises(SettingsError, match=r'driver.i2c.rate: 90 is not allowed.*100'):
        I2cSettings(rate=90.0)
