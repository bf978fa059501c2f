"""The page on troubleshooting names what there is."""

import re
from pathlib import Path

import pytest

from dead_reckoning.configuration import PARTS
from dead_reckoning.core import errors

PAGE = (Path(__file__).parents[1] / 'docs' / 'troubleshooting.md').read_text(encoding='utf-8')
ERRORS = sorted(set(re.findall(r'`(\w+Error)`', PAGE)))
PREFIXES = {part.prefix for part in PARTS}
KEYS = sorted(
    key
    for key in set(re.findall(r'`([a-z_]+\.[a-z_.]+)(?::[^`]*)?`', PAGE))
    if key.partition('.')[0] in PREFIXES
)


@pytest.mark.parametrize('name', ERRORS)
def test_every_count_is_an_error_of_this_package(name):
    assert issubclass(getattr(errors, name), errors.DeadReckoningError)


@pytest.mark.parametrize('key', KEYS)
def test_every_key_is_a_parameter(key):
    assert key in {parameter.key for part in PARTS for parameter in part.parameters()}


def test_they_are_found():
    assert len(ERRORS) > 15
    assert len(KEYS) > 8
    standing = (errors.SilentInputError, errors.MismatchError, errors.ClockError)
    assert {kind.__name__ for kind in standing} <= set(ERRORS)


@pytest.mark.parametrize(
    'family', [errors.PortError, errors.DeviceError, errors.ReadingError], ids=lambda f: f.__name__
)
def test_all_that_a_sensor_may_suffer_is_there(family):
    assert {kind.__name__ for kind in family.__subclasses__()} <= set(ERRORS)
