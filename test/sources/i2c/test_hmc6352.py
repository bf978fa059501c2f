"""An HMC6352 by its commands and delays, and as the kernel shows it."""

import math
from itertools import islice
from types import SimpleNamespace

import numpy as np
import pytest
from models import BusModel, Hmc6352Model, World

from dead_reckoning.core.compass import Compass, CompassSettings
from dead_reckoning.core.errors import (
    LostDeviceError,
    MissingDeviceError,
    NumberError,
    OutOfRangeError,
    RefusedSettingError,
    SettingsError,
)
from dead_reckoning.core.rotation import yaw_from_quaternion
from dead_reckoning.sources.devices import Calibration, Heading, Opened
from dead_reckoning.sources.i2c.hmc6352 import Hmc6352, Hmc6352Settings


class Bench:
    def __init__(self, world, folder='', **compass):
        self.world = world
        self.model = Hmc6352Model(world)
        self.bus = BusModel(world, self.model)
        settings = Hmc6352Settings(folder=str(folder))
        bus = None if folder else self.bus
        self.compass = Hmc6352(settings, CompassSettings(**compass), bus, world.now)

    def session(self):
        return self.compass.session(self.world.wait)


@pytest.fixture
def world(monkeypatch):
    """Give the model's clock, which the driver goes by too."""
    world = World()
    clock = SimpleNamespace(monotonic=lambda: world.now_ns * 1e-9)
    monkeypatch.setattr('dead_reckoning.sources.i2c.hmc6352.time', clock)
    return world


@pytest.fixture
def folder(tmp_path):
    """Give a folder as the kernel's driver makes it."""
    folder = tmp_path / '1-0021' / 'hmc6352'
    folder.mkdir(parents=True)
    (folder / 'heading0_input').write_text('123.4\n')
    (folder / 'calibration').write_text('')
    return folder


def some(session, count, kind=Heading):
    return list(islice((event for event in session if isinstance(event, kind)), count))


def test_it_is_set_up_for_20_headings_a_second(world):
    bench = Bench(world)
    session = bench.session()
    assert next(session) == Opened()
    assert bench.model.ram == {0x74: 0x72, 0x4E: 0}
    assert bench.model.log == [b'G\x74\x72', b'g\x74', b'G\x4e\x00', b'g\x4e']
    session.close()
    assert bench.bus.opened == 0


def test_a_memory_that_does_not_keep_the_mode_is_named(world):
    bench = Bench(world)
    bench.model.keeps = False
    with pytest.raises(RefusedSettingError, match=r'0x74 holds 0x50 after 0x72'):
        next(bench.session())


def test_headings_are_big_endian_tenths_of_a_degree(world):
    bench = Bench(world)
    bench.model.heading = 0x0102
    (found,) = some(bench.session(), 1)
    assert math.degrees(found.heading) == pytest.approx(25.8)


def test_headings_come_at_their_rate_and_carry_when_they_were_measured(world):
    """A heading of 20 a second is 25 ms old on average when it is asked for."""
    bench = Bench(world)
    session = bench.session()
    next(session)
    begun = world.now_ns
    found = some(session, 20)
    assert found[0].stamp_ns == begun - 25_000_000
    np.testing.assert_allclose(np.diff([h.stamp_ns for h in found]), 50e6, atol=1e3)


@pytest.mark.parametrize('tenths', [3600, 0xFFFF])
def test_what_is_no_heading_is_an_error_and_the_next_one_comes(world, tenths):
    bench = Bench(world)
    session = bench.session()
    next(session)
    bench.model.heading = tenths
    found = next(session)
    assert isinstance(found, OutOfRangeError)
    assert str(tenths) in str(found)
    bench.model.heading = 3599
    assert math.degrees(some(session, 1)[0].heading) == pytest.approx(359.9)


def test_yaw_is_left_hand_from_east_with_the_declination():
    """North, 0°, is a yaw of 90°; magnetic north 10° east of it takes those off."""
    compass = Compass(CompassSettings(declination=math.radians(10.0)), 'imu_link')
    yaw = yaw_from_quaternion(compass.sample(1, 0.0).orientation)
    assert math.degrees(yaw) == pytest.approx(80.0)


def test_calibration_enters_waits_and_leaves(world):
    bench = Bench(world, calibration_time=12.0)
    session = bench.session()
    next(session)
    next(session)
    begun = world.now_ns
    bench.compass.calibrate()
    said = [event.said for event in islice(session, 200) if isinstance(event, Calibration)]
    assert not any(said[:-1])
    assert 'calibrated for 12 s' in said[-1]
    entered, left = bench.model.log.index(b'C'), bench.model.log.index(b'E')
    assert left == entered + 1
    assert not bench.model.calibrating
    assert world.now_ns - begun > 12e9


def test_a_calibration_asked_for_again_begins_anew(world):
    bench = Bench(world, calibration_time=10.0)
    session = bench.session()
    next(session)
    begun = world.now_ns
    bench.compass.calibrate()
    while world.now_ns - begun < 8e9:
        next(session)
    bench.compass.calibrate()
    while not (isinstance(event := next(session), Calibration) and event.said):
        pass
    assert 17e9 < world.now_ns - begun < 19e9
    assert bench.model.log.count(b'C') == 1
    assert len(some(session, 3)) == 3


def test_a_request_that_is_withdrawn_is_forgotten(world):
    bench = Bench(world)
    bench.compass.calibrate()
    bench.compass.abandon()
    some(bench.session(), 3)
    assert b'C' not in bench.model.log


def test_an_end_amid_the_calibration_leaves_it(world):
    bench = Bench(world)
    session = bench.session()
    next(session)
    bench.compass.calibrate()
    next(session)
    assert bench.model.calibrating
    session.close()
    assert not bench.model.calibrating
    assert bench.bus.opened == 0


def test_a_compass_lost_amid_the_calibration_goes_on_as_before(world):
    bench = Bench(world)
    session = bench.session()
    next(session)
    bench.compass.calibrate()
    next(session)
    bench.bus.plugged = False
    with pytest.raises(MissingDeviceError):
        list(islice(session, 1000))
    assert bench.model.calibrating
    bench.bus.plugged = True
    assert len(some(bench.session(), 3)) == 3


def test_a_supply_lost_and_back_amid_the_calibration_leaves_the_mode_as_set(world):
    bench = Bench(world)
    session = bench.session()
    next(session)
    bench.compass.calibrate()
    next(session)
    bench.model.ram[0x74], bench.model.calibrating = 0x50, False
    assert len(some(session, 3)) == 3
    assert bench.model.ram[0x74] == 0x72


def test_a_rate_it_does_not_have_is_refused(world):
    with pytest.raises(SettingsError, match=r'compass.rate: 15 .* 1, 5, 10 or 20'):
        Bench(world, rate=15.0)


def test_sysfs_has_headings_in_degrees(world, folder):
    bench = Bench(world, folder, rate=15.0)
    session = bench.session()
    assert next(session) == Opened()
    found = some(session, 3)
    assert math.degrees(found[-1].heading) == pytest.approx(123.4)
    np.testing.assert_allclose(np.diff([h.stamp_ns for h in found]), 1e9 / 15.0, atol=1e3)


@pytest.mark.parametrize(
    ('text', 'error'), [('360.0', OutOfRangeError), ('', NumberError), ('inf', NumberError)]
)
def test_sysfs_that_holds_no_heading(world, folder, text, error):
    session = Bench(world, folder).session()
    next(session)
    (folder / 'heading0_input').write_text(text)
    assert isinstance(next(session), error)


def test_sysfs_calibration_writes_1_then_0(world, folder):
    bench = Bench(world, folder, calibration_time=1.0)
    session = bench.session()
    next(session)
    bench.compass.calibrate()
    assert next(session) == Calibration()
    assert (folder / 'calibration').read_text() == '1'
    while not (event := next(session)).said:
        pass
    assert 'calibrated' in event.said
    assert (folder / 'calibration').read_text() == '0'


def test_a_calibration_that_may_not_be_entered_costs_no_more_than_itself(world, folder):
    """As where the file belongs to root: everybody may read the heading beside it."""
    bench = Bench(world, folder)
    session = bench.session()
    next(session)
    (folder / 'calibration').unlink()
    (folder / 'calibration').mkdir()
    bench.compass.calibrate()
    with pytest.raises(LostDeviceError):
        list(islice(session, 10))
    bench.compass.abandon()
    assert len(some(bench.session(), 3)) == 3


def test_sysfs_without_a_compass_says_how_to_get_one(world, tmp_path):
    with pytest.raises(MissingDeviceError, match='new_device'):
        next(Bench(world, tmp_path / 'nothing').session())


def test_sysfs_that_fails_to_answer(world, folder, monkeypatch):
    session = Bench(world, folder).session()
    next(session)
    (folder / 'heading0_input').unlink()
    (folder / 'heading0_input').mkdir()
    with pytest.raises(LostDeviceError, match='does not answer'):
        next(session)
