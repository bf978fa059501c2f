"""Write config/*.yaml and docs/parameters.md from the declarations of the parameters.

``python -m dead_reckoning.tools.generate`` in the source tree; a test compares the files with what
this would write.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import fill
from typing import Any

from dead_reckoning.configuration import PARTS
from dead_reckoning.core.parameters import Derived, Parameter, Settings


@dataclass(frozen=True)
class Preset:
    """One file of config/: what it is for, and the values that differ from the defaults.

    ``whole`` writes every parameter, else only those that differ.  ``other`` values are another
    choice, which the words explain: they stand below the first as comments.
    """

    name: str
    words: str
    values: Mapping[str, Any]
    whole: bool = False
    other: Mapping[str, Any] = field(default_factory=dict)


PRESETS = (
    Preset(
        'mma7260qt',
        'The default: an MMA7260QT at ±1.5 g behind a 12-bit ADC, simulated. Every parameter of '
        'every node is here with its default; what is commented out follows from other values.',
        {},
        whole=True,
    ),
    Preset(
        'an3397',
        'Freescale AN3397: an MMA7260QT at ±1.5 g behind an 8-bit ADC, moved about in the plane; '
        '64 conversions a sample, a window of ±3 counts of 16.1 mg, 25 quiet samples that end the '
        'movement of an axis. As comments its other choice, "±2 sample steps for an average of '
        '16 samples".',
        {
            'driver.motion': 'square',
            'driver.sensor': 'mma7260qt',
            'driver.range_g': 1.5,
            'driver.adc_bits': 8,
            'driver.samples_per_message': 64,
            'driver.calibration_samples': 1024,
            'integrator.method': 'trapezoid',
            'integrator.axes': ['x', 'y'],
            'integrator.window_minimum': -0.474,
            'integrator.window_maximum': 0.474,
            'integrator.movement_end': 'each',
            'integrator.movement_end_samples': 25,
        },
        other={
            'driver.samples_per_message': 16,
            'integrator.window_minimum': -0.316,
            'integrator.window_maximum': 0.316,
        },
    ),
    Preset(
        'mbed',
        'The mbed tutorial "Dead Reckoning": an ADXL345 at ±16 g and 3200 Hz, averaged to 100 Hz, '
        'distance along the heading of a compass, logged for 15 s. Run `pipeline` and '
        '`compass_driver` with it; a vehicle of the simulator drives them in curves.',
        {
            'driver.motion': 'vehicle',
            'driver.sensor': 'adxl345',
            'driver.range_g': 16.0,
            'driver.sample_rate': 3200.0,
            'driver.samples_per_message': 32,
            'driver.vehicle.length': 6.0,
            'driver.vehicle.width': 3.0,
            'driver.vehicle.loops': 1,
            'driver.vehicle.loop_time': 9.0,
            'driver.vehicle.pause': 0.7,
            'gravity.attitude': 'rest',
            'integrator.method': 'trapezoid',
            'integrator.axes': ['x'],
            'integrator.window_minimum': -0.06,
            'integrator.window_maximum': 0.06,
            'pipeline.source': 'simulated',
            'pipeline.log_csv': 'results.csv',
            'pipeline.duration': 15.0,
        },
    ),
    Preset(
        'an900',
        'The pedometer of Analog Devices AN-900: an ADXL330 worn with its y axis up, 30 messages '
        'a second of four conversions each, steps counted on x and y; simulated, on a walk. A '
        'device that stands upright has no level rest to find its zero-g offsets in.',
        {
            'driver.motion': 'walk',
            'driver.sensor': 'adxl330',
            'driver.sample_rate': 120.0,
            'driver.samples_per_message': 4,
            'driver.calibrate_on_start': False,
            'driver.walk.roll': 1.5708,
            'pedometer.axes': ('x', 'y'),
            'pedometer.length_model': 'an900_equation2',
        },
    ),
)


def files() -> dict[str, str]:
    """Return the text of each generated file by its path in the source tree."""
    texts = {f'config/{preset.name}.yaml': yaml_of(preset) for preset in PRESETS}
    texts['docs/parameters.md'] = reference()
    return texts


def yaml_of(preset: Preset) -> str:
    """Return a preset as a ROS parameter file."""
    lines = [*_comment(preset.words, ''), '# Made by `make config`; copy it to change it.', '']
    lines += ['/**:', '  ros__parameters:']
    for part in PARTS:
        chosen = [p for p in part.parameters() if preset.whole or p.key in preset.values]
        if chosen:
            lines += ['', f'    # {part.prefix}: {_first_line(part)}']
        for parameter in chosen:
            lines += _entry(parameter, part, preset.values)
            if parameter.key in preset.other:
                lines.append(f'    # {parameter.key}: {_yaml(preset.other[parameter.key])}')
    return '\n'.join(lines) + '\n'


def _entry(parameter: Parameter, part: type[Settings], values: Mapping[str, Any]) -> list[str]:
    lines = ['', *_comment(f'{parameter.description}; {parameter.allowed()}', '    ')]
    derived = isinstance(parameter.default, Derived) and parameter.key not in values
    value = values.get(parameter.key, part().values()[parameter.key])
    if derived:
        lines += _comment(f'Default: {parameter.default.words}', '    ')
    lines.append(f'    {"# " if derived else ""}{parameter.key}: {_yaml(value)}')
    return lines


def reference() -> str:
    """Return the reference page of all parameters."""
    lines = [
        '# Parameters',
        '',
        'Made by `make config` from the declarations in the code. A node declares the keys of',
        'its own part and those of `common` and `frames`, knows the keys of the other parts, and',
        'stops at any other key and at any value outside of what is allowed. An integer is',
        'accepted where a number is meant. Parameters marked *live* can be changed while a node',
        'runs.',
        '',
    ]
    for part in PARTS:
        lines += [f'## {part.prefix}', '', _first_line(part), '']
        lines += ['| key | default | allowed | meaning |', '|---|---|---|---|']
        lines += [_row(parameter) for parameter in part.parameters()]
        lines.append('')
    return '\n'.join(lines).rstrip() + '\n'


def _row(parameter: Parameter) -> str:
    default = parameter.default
    shown = default.words if isinstance(default, Derived) else f'`{_yaml(default)}`'
    live = ' *live*' if parameter.mutable else ''
    cells = (f'`{parameter.key}`', shown, parameter.allowed(), parameter.description + live)
    return '| ' + ' | '.join(cell.replace('|', r'\|') for cell in cells) + ' |'


def _yaml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (tuple, list)):
        return '[' + ', '.join(_yaml(element) for element in value) + ']'
    return f"'{value}'" if isinstance(value, str) else repr(value)


def _comment(text: str, indent: str) -> list[str]:
    return fill(text, 99, initial_indent=f'{indent}# ', subsequent_indent=f'{indent}# ').split(
        '\n'
    )


def _first_line(part: type[Settings]) -> str:
    return (part.__doc__ or '').split('\n')[0].rstrip('.')


def main() -> int:
    """Write the files into the source tree that this module stands in."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    root = Path(__file__).parents[2]
    for name, text in files().items():
        path = root / name
        path.parent.mkdir(exist_ok=True)
        if not path.exists() or path.read_text(encoding='utf-8') != text:
            path.write_text(text, encoding='utf-8')
            print(f'wrote {name}')
    return 0


if __name__ == '__main__':
    sys.exit(main())
