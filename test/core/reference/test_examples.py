"""Examples in docstrings run, and the page on the programs prints what they give."""

import doctest
import re
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from dead_reckoning.core.reference import an3397

PAGE = (Path(__file__).parents[3] / 'docs' / 'reference-algorithms.md').read_text(encoding='utf-8')


@pytest.mark.parametrize('name', ['wrap', 'an3397_frame', 'mbed', 'an900', 'attitude_error'])
def test_examples_in_docstrings_run(name):
    found = doctest.testmod(import_module(f'dead_reckoning.core.reference.{name}'))
    assert found.attempted > 0
    assert found.failed == 0


def test_example_of_the_page_runs(capsys):
    (code,) = re.findall(r'```python\n(.*?)```', PAGE, re.DOTALL)
    exec(code, {})
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == 10
    assert printed[0] == '5 -5 (0, 0)'


@pytest.mark.parametrize(('corrected', 'label'), [(False, 'as printed'), (True, '`--corrected`')])
@pytest.mark.parametrize(('sign', 'way'), [(1, 'forward'), (-1, 'backward')])
def test_table_of_the_page_is_what_the_program_gives(corrected, label, sign, way):
    levels = [0] * 16 + [20] * 10 + [-20] * 10 + [0] * 5
    column = np.repeat(128 + sign * np.array(levels), 64)
    last = an3397.run(np.stack((column, column), axis=1), corrected=corrected)[-1]
    numbers = f'{last.vx} | {last.px}'.replace('-', '−')
    assert f'| {label}, {way} | {numbers} |' in PAGE
