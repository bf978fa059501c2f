"""The committed configuration and reference are what the declarations say."""

from pathlib import Path

import pytest
import yaml

from dead_reckoning.configuration import PARTS, Configuration, read_values
from dead_reckoning.tools.generate import PRESETS, files

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize('name', files())
def test_committed_file_is_up_to_date(name):
    assert (ROOT / name).read_text(encoding='utf-8') == files()[name], 'run `make config`'


@pytest.mark.parametrize('preset', PRESETS, ids=lambda preset: preset.name)
def test_preset_loads(preset):
    configuration = Configuration.load(ROOT / 'config' / f'{preset.name}.yaml')
    defaults = Configuration(preset.values)
    for part in PARTS:
        assert configuration[part].values() == defaults[part].values()


def test_default_file_names_every_parameter():
    text = (ROOT / 'config' / 'mma7260qt.yaml').read_text(encoding='utf-8')
    for part in PARTS:
        for parameter in part.parameters():
            assert f'    {parameter.key}: ' in text or f'    # {parameter.key}: ' in text


def test_strings_are_quoted_for_rcl():
    """rcl reads an unquoted y as a boolean, so every string of the files must be quoted."""
    text = (ROOT / 'config' / 'mma7260qt.yaml').read_text(encoding='utf-8')
    axes = read_values(ROOT / 'config' / 'mma7260qt.yaml')['integrator.axes']
    assert axes == ['x', 'y', 'z']
    assert "integrator.axes: ['x', 'y', 'z']" in text
    assert yaml.safe_load(text)['/**']['ros__parameters']['driver.slide.axis'] == 'x'
    assert "driver.slide.axis: 'x'" in text
