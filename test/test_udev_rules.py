"""The udev rules do for each device what the pages say, at every event it has."""

import re
from fnmatch import fnmatchcase
from pathlib import Path

import pytest

RULES = Path(__file__).parents[1] / 'config' / '99-dead-reckoning.rules'
TOKEN = re.compile(r'([A-Z]+(?:\{\w+\})?)(==|!=|\+=|=)"([^"]*)"(?:, |$)')
IGNORE = 'ENV{ID_MM_DEVICE_IGNORE}'


def assigned(**event):
    """Return what the rules assign for an event; ``vendor`` is that of the USB device above it."""
    if 'vendor' in event:
        event['ATTRS{idVendor}'] = event.pop('vendor')
    found, goto = {}, None
    for line in RULES.read_text(encoding='utf-8').splitlines():
        if not line or line.startswith('#'):
            continue
        tokens = TOKEN.findall(line)
        assert ', '.join(f'{key}{sign}"{value}"' for key, sign, value in tokens) == line
        if goto is not None and ('LABEL', '=', goto) not in tokens:
            continue
        goto = None
        if all(
            matches(event.get(key, ''), value) == (sign == '==')
            for key, sign, value in tokens
            if sign in ('==', '!=')
        ):
            new = {key: value for key, sign, value in tokens if sign in ('=', '+=')}
            goto = new.pop('GOTO', None)
            found |= new
    assert goto is None, 'a label is missing'
    found.pop('LABEL', None)
    return found


def matches(value, patterns):
    return any(fnmatchcase(value, pattern) for pattern in patterns.split('|'))


@pytest.mark.parametrize('action', ['add', 'bind', 'change', 'move'])
@pytest.mark.parametrize('vendor', ['0403', '2341', '15a2'])
def test_modemmanager_leaves_adapters_and_boards_alone_after_every_event(action, vendor):
    assert assigned(ACTION=action, SUBSYSTEM='usb', vendor=vendor) == {IGNORE: '1'}


@pytest.mark.parametrize('event', [{'vendor': '12d1', 'ACTION': 'add'}, {'ACTION': 'add'}])
def test_other_devices_are_left_as_they_are(event):
    assert assigned(SUBSYSTEM='usb', **event) == {}


def test_ftdi_adapters_hand_bytes_over_at_once():
    found = assigned(ACTION='add', SUBSYSTEM='usb-serial', DRIVER='ftdi_sio', vendor='0403')
    assert found == {'ATTR{latency_timer}': '1', IGNORE: '1'}


@pytest.mark.parametrize('kernel', ['iio:device0', 'trigger3'])
def test_accelerometers_of_the_kernel_and_their_triggers_may_be_set_up(kernel):
    found = assigned(ACTION='add', SUBSYSTEM='iio', KERNEL=kernel)
    assert found['GROUP'] == 'dialout'
    assert found['MODE'] == '0660'
    assert 'chmod -R g+w /sys%p' in found['RUN']


@pytest.mark.parametrize('action', ['add', 'bind'])
def test_an_hmc6352_may_be_calibrated_once_its_driver_has_it(action):
    event = {'ACTION': action, 'SUBSYSTEM': 'i2c'}
    assert 'calibration' in assigned(DRIVER='hmc6352', **event)['RUN']
    assert assigned(DRIVER='', **event) == {}
