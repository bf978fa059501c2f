"""Laws that every error keeps."""

import inspect

import pytest

from dead_reckoning.core import errors

ERRORS = [
    kind
    for _, kind in inspect.getmembers(errors, inspect.isclass)
    if issubclass(kind, BaseException)
]


@pytest.mark.parametrize('kind', ERRORS)
def test_error_has_the_one_root(kind):
    assert issubclass(kind, errors.DeadReckoningError)


@pytest.mark.parametrize('kind', ERRORS)
def test_error_says_in_its_docstring_what_it_means(kind):
    assert kind.__dict__['__doc__'], f'{kind.__name__} has no docstring of its own'


def test_errors_are_found():
    assert len(ERRORS) > 10
    assert errors.SampleError in ERRORS
