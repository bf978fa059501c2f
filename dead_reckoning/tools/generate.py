"""Write config/*.yaml and docs/parameters.md from the declarations of the parameters.

``python -m dead_reckoning.tools.generate`` in the source tree; a test compares the files with what
this would write.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path
from textwrap import fill
from typing import Any

from dead_reckoning.configuration import PARTS
from dead_reckoning.core.parameters import Derived, Parameter, Settings
from dead_reckoning.tools.presets import PRESETS, Preset


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
    for part in (part for part in PARTS if part.parameters()):
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
