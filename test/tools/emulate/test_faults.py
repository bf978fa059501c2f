"""`--faults`: what it takes, and that it names what it refuses."""

import argparse

import pytest

from dead_reckoning.tools.emulate.faults import Faults, parse


@pytest.mark.parametrize(
    ('text', 'faults'),
    [
        ('drop:0.001', Faults(drop=0.001)),
        (
            'drop:0.001,flip:0.002,double:1e-3,pause:0,hangup:10',
            Faults(drop=0.001, flip=0.002, double=0.001, hangup=10.0),
        ),
        (' flip:1 , hangup:0.1', Faults(flip=1.0, hangup=0.1)),
    ],
)
def test_a_list_of_faults(text, faults):
    assert parse(text) == faults


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('', "'' is no fault; allowed are drop, flip, double, pause, hangup"),
        ('drip:0.1', "'drip:0.1' is no fault"),
        ('drop', "'drop' is no fault"),
        ('drop=0.1', "'drop=0.1' is no fault"),
        ('drop:0.1,', "'' is no fault"),
        ('drop:1.5', 'drop: 1.5 is not allowed; a probability'),
        ('flip:-0.1', 'flip: -0.1 is not allowed; a probability of each byte, from 0 to 1'),
        ('double:nan', 'nan is not finite'),
        ('pause:often', "'often' is no number"),
        ('hangup:0', 'hangup: 0 is not allowed; a time from 0.1 s'),
        ('drop:0.1,drop:0.2', 'drop is there twice'),
    ],
)
def test_what_is_refused_is_named(text, words):
    with pytest.raises(argparse.ArgumentTypeError) as caught:
        parse(text)
    assert words in str(caught.value)
