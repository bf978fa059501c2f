"""Rooms of the package import in one direction; outside libraries stay in their rooms.

Every module is read, never imported, so that what is not installed here is judged too.
"""

import ast
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

import dead_reckoning

PACKAGE = 'dead_reckoning'
ROOT = Path(dead_reckoning.__file__).parent
STANDARD = frozenset(sys.stdlib_module_names)

OUTSIDE_WORLD = {
    *('time', 'datetime', 'sched', 'logging', 'warnings', 'getpass', 'locale'),
    *('os', 'io', 'pathlib', 'shutil', 'tempfile', 'glob', 'fileinput', 'mmap', 'sys'),
    *('pickle', 'shelve', 'dbm', 'sqlite3', 'csv', 'json', 'configparser', 'tomllib', 'zipfile'),
    *('socket', 'ssl', 'http', 'urllib', 'select', 'selectors', 'subprocess', 'signal', 'random'),
    *('asyncio', 'threading', 'multiprocessing', 'ctypes', 'platform', 'importlib', 'pkgutil'),
}
"""Of the standard library, what core must not see: clocks, logs, files, the system, chance."""

FORBIDDEN_CALLS = {'open', 'print', 'input', 'exec', 'eval', '__import__', 'breakpoint'}
"""Built-in functions that core must not call."""

ROS = {
    *('rclpy', 'rcl_interfaces', 'builtin_interfaces', 'tf2_ros', 'tf2_py', 'rosidl_runtime_py'),
    *('rpyutils', 'launch', 'launch_ros', 'launch_testing', 'ament_index_python', 'rosbag2_py'),
    *('rosidl_parser', 'ros2cli', 'ros2run', 'rosgraph_msgs', 'message_filters'),
}
NUMERIC = {'numpy', 'scipy', 'filterpy'}
ONE_MODULE_EACH = {'rosbags', 'serial', 'smbus2', 'numba'}
"""Outside libraries that only one module may import."""


def is_ros(top: str) -> bool:
    return top in ROS or top.endswith(('_msgs', '_srvs', '_interfaces'))


def room_of(module: str) -> str:
    """Return the room of a module: core, sources, nodes, tools, or its own name beside them."""
    parts = module.split('.')
    return parts[1] if len(parts) > 1 else ''


BESIDE = {'configuration', 'tables', 'wire', 'block_wire', 'topics', 'live'}
"""Modules beside the rooms, for all that is above core and sources."""

ALLOWED_ROOMS = {
    '': set(),
    'core': {'core'},
    'sources': {'core', 'sources', 'wire', 'block_wire'},
    'configuration': {'core', 'sources'},
    'tables': {'core'},
    'wire': {'core'},
    'block_wire': {'core', 'wire'},
    'topics': {'core', 'wire', 'block_wire'},
    'live': {'core', 'wire', 'block_wire', 'live'},
    'nodes': {'core', 'sources', 'nodes', *BESIDE},
    'tools': {'core', 'sources', 'tools', *BESIDE},
}


OWN_MODULES = {'importlib', 'pkgutil'}
"""What the ``__init__`` of a package in core may use, to find its own modules by their names."""


def may_import(room: str, top: str, is_package: bool = False) -> bool:
    """Say whether a room may import a top-level module from outside the package."""
    if top in STANDARD:
        outside = OUTSIDE_WORLD - OWN_MODULES if is_package else OUTSIDE_WORLD
        return room != 'core' or top not in outside
    if is_ros(top):
        return room == 'nodes'
    return {
        '': False,
        'core': top in NUMERIC | {'numba'},
        'sources': top in NUMERIC | ONE_MODULE_EACH - {'numba'},
        'configuration': top == 'yaml',
        'tables': top in {*NUMERIC, 'orjson'},
        'wire': False,
        'block_wire': top in NUMERIC,
        'topics': False,
        'live': top in NUMERIC,
        'nodes': top in NUMERIC,
        'tools': top not in ONE_MODULE_EACH,
    }[room]


def imports(module: str, tree: ast.AST, is_package: bool) -> Iterator[tuple[int, str]]:
    """Yield line and full name of everything imported, wherever in the module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ''
            if node.level:
                parents = module.split('.')
                kept = len(parents) - node.level + is_package
                base = '.'.join([*parents[:kept], *([base] if base else [])])
            for alias in node.names:
                # `from package import name` may name a module as well as something in it.
                inside = base.split('.')[0] == PACKAGE
                yield node.lineno, f'{base}.{alias.name}' if inside else base


def faults(module: str, source: str, is_package: bool = False) -> list[str]:
    """List what a module imports or calls against the directions, each with line and rule."""
    room = room_of(module)
    if room not in ALLOWED_ROOMS:
        return [f'{module}: no such room; tell {Path(__file__).name} what it may import']
    tree = ast.parse(source)
    found = []
    for line, name in imports(module, tree, is_package):
        top = name.split('.')[0]
        if top == PACKAGE:
            target = room_of(name)
            if target in ALLOWED_ROOMS and target not in ALLOWED_ROOMS[room] and target:
                found.append(f'{module}, line {line}: {room} imports {name}')
        elif top != '__future__' and not may_import(room, top, is_package):
            found.append(f'{module}, line {line}: {room} imports {name}')
    if room == 'core':
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                if node.func.id in FORBIDDEN_CALLS:
                    found.append(f'{module}, line {node.lineno}: core calls {node.func.id}()')
            elif isinstance(node, ast.Attribute) and node.attr in ('read_text', 'write_text'):
                found.append(f'{module}, line {node.lineno}: core uses .{node.attr}')
    return found


def modules() -> dict[str, tuple[Path, bool]]:
    found = {}
    for path in sorted(ROOT.rglob('*.py')):
        parts = path.relative_to(ROOT.parent).with_suffix('').parts
        is_package = parts[-1] == '__init__'
        found['.'.join(parts[:-1] if is_package else parts)] = (path, is_package)
    return found


MODULES = modules()


@pytest.mark.parametrize('module', MODULES)
def test_module_imports_in_the_allowed_direction(module):
    path, is_package = MODULES[module]
    found = faults(module, path.read_text(encoding='utf-8'), is_package)
    assert not found, '\n'.join(found)


def test_outside_library_is_imported_by_one_module_only():
    users = defaultdict(set)
    for module, (path, is_package) in MODULES.items():
        tree = ast.parse(path.read_text(encoding='utf-8'))
        for _, name in imports(module, tree, is_package):
            top = name.split('.')[0]
            if top in ONE_MODULE_EACH:
                users[top].add(module)
    shared = {library: sorted(of) for library, of in users.items() if len(of) > 1}
    assert not shared, f'imported by more than one module: {shared}'


def test_all_rooms_are_walked():
    assert {room_of(module) for module in MODULES} >= {'', 'core', 'sources', 'configuration'}
    assert len([module for module in MODULES if room_of(module) == 'core']) > 15


@pytest.mark.parametrize(
    ('module', 'source'),
    [
        ('core.a', 'import rclpy'),
        ('core.a', 'import time'),
        ('core.a', 'from datetime import datetime'),
        ('core.a', 'import logging as log'),
        ('core.a', 'from pathlib import Path'),
        ('core.a', 'def late():\n    import os.path'),
        ('core.a', 'import yaml'),
        ('core.a', 'import serial'),
        ('core.a', 'from sensor_msgs.msg import Imu'),
        ('core.a', 'from dead_reckoning.sources import motions'),
        ('core.a', 'from dead_reckoning import configuration'),
        ('core.a', 'from .. import wire'),
        ('core.a', 'from ..configuration import PARTS'),
        ('core.a', "text = open('file')"),
        ('core.a', "print('here')"),
        ('core.a', 'text = path.read_text()'),
        ('core.kernels.a', 'import dead_reckoning.wire'),
        ('core.kernels.a', 'from ... import wire'),
        ('sources.a', 'import rclpy'),
        ('sources.a', 'import yaml'),
        ('sources.a', 'from dead_reckoning.configuration import PARTS'),
        ('sources.a', 'from dead_reckoning.nodes import topics'),
        ('sources.a', 'from dead_reckoning.tools import replay'),
        ('configuration', 'import rclpy'),
        ('configuration', 'import numpy'),
        ('configuration', 'from dead_reckoning import wire'),
        ('nodes.a', 'from dead_reckoning.tools import replay'),
        ('nodes.a', 'import serial'),
        ('nodes.a', 'import yaml'),
        ('tools.a', 'import rclpy'),
        ('tools.a', 'from sensor_msgs.msg import Imu'),
        ('tools.a', 'from dead_reckoning.nodes import topics'),
        ('tools.a', 'import rosbags.rosbag2'),
        ('wire', 'from sensor_msgs.msg import Imu'),
        ('wire', 'from dead_reckoning.sources import bags'),
        ('topics', 'from dead_reckoning.nodes import topics'),
        ('attic.a', 'import math'),
    ],
)
def test_wrong_import_is_found(module, source):
    (fault,) = faults(f'{PACKAGE}.{module}', source)
    assert fault.startswith(f'{PACKAGE}.{module}')


def test_package_in_core_may_find_its_own_modules_and_a_module_may_not():
    source = 'import pkgutil\nfrom importlib import import_module'
    assert faults(f'{PACKAGE}.core.a', source, is_package=True) == []
    assert len(faults(f'{PACKAGE}.core.a', source)) == 2
    (fault,) = faults(f'{PACKAGE}.core.a', 'import time', is_package=True)
    assert 'time' in fault


@pytest.mark.parametrize(
    ('module', 'source'),
    [
        ('core.a', 'from __future__ import annotations'),
        ('core.a', 'import math, numpy as np'),
        ('core.a', 'from scipy.signal import butter'),
        ('core.a', 'import filterpy.kalman'),
        ('core.a', 'from concurrent.futures import Future'),
        ('core.a', 'from dead_reckoning.core.samples import ImuSample'),
        ('core.a', 'from .samples import ImuSample'),
        ('core.a', 'from . import samples'),
        ('core.a', 'reopen(1)'),
        ('sources.a', 'import time, serial'),
        ('sources.a', 'from rosbags.highlevel import AnyReader'),
        ('sources.a', 'from dead_reckoning.core import stages'),
        ('sources.a', 'from dead_reckoning import wire'),
        ('sources.motions.a', 'from dead_reckoning.sources.motions import Array'),
        ('configuration', 'import yaml\nfrom dead_reckoning.sources import motions'),
        ('nodes.a', 'import rclpy.node\nfrom sensor_msgs.msg import Imu'),
        ('nodes.a', 'from dead_reckoning.configuration import PARTS'),
        ('tools.a', 'import yaml, time\nfrom dead_reckoning.configuration import PARTS'),
        ('tools.a', 'from dead_reckoning.sources import bags'),
    ],
)
def test_right_import_passes(module, source):
    assert faults(f'{PACKAGE}.{module}', source) == []
