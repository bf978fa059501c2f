"""The package as colcon, rosdep and pip see it."""

import ast
import importlib
import os
import runpy
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = 'dead_reckoning'
IMPORTED_BY = {
    'python3-filterpy-pip': 'filterpy',
    'python3-hypothesis': 'hypothesis',
    'python3-matplotlib': 'matplotlib',
    'python3-numba': 'numba',
    'python3-numpy': 'numpy',
    'python3-orjson': 'orjson',
    'python3-scipy': 'scipy',
    'python3-pytest': 'pytest',
    'python3-rosbags-pip': 'rosbags',
    'python3-serial': 'serial',
    'python3-smbus2': 'smbus2',
    'python3-yaml': 'yaml',
    'tf2_ros_py': 'tf2_ros',
}
"""Rosdep keys that are not the name one imports."""
IMPORTED_FROM_PIP = {'PyYAML': 'yaml', 'pyserial': 'serial'}
OPTIONAL = {'distributed'}
"""What only those install who ask for what needs it."""

FROM_ROS = {
    'ament_index_python',
    'builtin_interfaces',
    'diagnostic_msgs',
    'geometry_msgs',
    'launch',
    'launch_ros',
    'nav_msgs',
    'rcl_interfaces',
    'rclpy',
    'rosgraph_msgs',
    'sensor_msgs',
    'std_msgs',
    'std_srvs',
    'tf2_msgs',
    'tf2_ros',
}


def third_party(*folders):
    """Return the names of the packages that modules in these folders import."""
    files = [path for folder in folders for path in (ROOT / folder).rglob('*.py')]
    assert files
    helpers = {path.stem for path in files if 'test' in folders}
    own = {PACKAGE, 'benchmarks', 'test', *helpers, *sys.stdlib_module_names}
    return {
        name.partition('.')[0]
        for path in files
        for node in ast.walk(ast.parse(path.read_text(encoding='utf-8')))
        for name in names_in(node)
    } - own


def names_in(node):
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom) and node.level == 0:
        return [node.module]
    if isinstance(node, ast.Call) and getattr(node.func, 'attr', '') == 'import_module':
        return [a.value for a in node.args if isinstance(getattr(a, 'value', None), str)]
    return []


@pytest.fixture(scope='module')
def manifest():
    return ElementTree.parse(ROOT / 'package.xml').getroot()


@pytest.fixture(scope='module')
def setup_arguments():
    """What setup.py hands to setuptools, paths relative to the checkout."""
    setuptools = pytest.importorskip('setuptools')
    handed = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        patch.setattr(setuptools, 'setup', lambda **arguments: handed.update(arguments))
        runpy.run_path('setup.py')
    return handed


def test_the_manifest_is_format_3_of_an_ament_python_package(manifest):
    assert manifest.tag == 'package'
    assert manifest.get('format') == '3'
    assert manifest.findtext('name') == PACKAGE
    assert manifest.findtext('export/build_type') == 'ament_python'
    assert manifest.findtext('license') == 'Apache-2.0'
    assert (ROOT / manifest.find('license').get('file')).is_file()
    assert manifest.findtext('description').strip()
    assert '@' in manifest.find('maintainer').get('email')


def test_each_import_has_its_rosdep_key_and_each_key_is_imported(manifest):
    declared = [e.text for e in manifest if e.tag == 'exec_depend']
    imported = third_party(PACKAGE, 'launch', 'benchmarks') - OPTIONAL
    assert sorted(declared) == sorted(set(declared))
    assert {IMPORTED_BY.get(key, key) for key in declared} == imported


def test_the_tests_imports_have_their_rosdep_keys(manifest):
    declared = {e.text for e in manifest if e.tag in ('exec_depend', 'test_depend')}
    known = {IMPORTED_BY.get(key, key) for key in declared}
    assert third_party('test') - {'setuptools'} - OPTIONAL <= known


def test_pip_requires_what_is_imported_and_does_not_come_with_ros(setup_arguments):
    required = {IMPORTED_FROM_PIP.get(name, name) for name in setup_arguments['install_requires']}
    extras = setup_arguments['extras_require']
    assert {name for extra in extras if extra != 'test' for name in extras[extra]} == OPTIONAL
    assert required == third_party(PACKAGE, 'benchmarks') - FROM_ROS - OPTIONAL


def test_setup_and_manifest_agree(manifest, setup_arguments):
    assert setup_arguments['version'] == manifest.findtext('version')
    assert setup_arguments['name'] == manifest.findtext('name')
    assert setup_arguments['license'] == manifest.findtext('license')
    assert setup_arguments['maintainer'] == manifest.findtext('maintainer')
    assert setup_arguments['maintainer_email'] == manifest.find('maintainer').get('email')


def test_every_executable_is_a_function(setup_arguments):
    scripts = setup_arguments['entry_points']['console_scripts']
    assert {script.split(' = ')[0] for script in scripts} == {
        'accelerometer_driver',
        'compass_driver',
        'gravity_removal',
        'inertial_navigator',
        'integrator',
        'pedometer',
        'pipeline',
        'dead-reckoning',
    }
    for script in scripts:
        module, _, function = script.split(' = ')[1].partition(':')
        assert callable(getattr(importlib.import_module(module), function))


def test_an_installation_holds_every_module_executable_config_and_launch_file(
    setup_arguments, tmp_path
):
    pytest.importorskip('pip')
    checkout, prefix = tmp_path / 'checkout', tmp_path / 'prefix'
    checkout.mkdir()
    for name in ('package.xml', 'setup.py', 'setup.cfg', 'pyproject.toml'):
        shutil.copy(ROOT / name, checkout)
    for name in ('resource', PACKAGE, 'config', 'launch', 'test'):
        ignore = shutil.ignore_patterns('__pycache__')
        shutil.copytree(ROOT / name, checkout / name, ignore=ignore)
    pip = [sys.executable, '-m', 'pip', 'install', '--quiet', '--disable-pip-version-check']
    pip += ['--no-build-isolation', '--no-deps', '--no-index', '--prefix', prefix, checkout]
    subprocess.run(pip, check=True, cwd=tmp_path)

    (installed,) = prefix.glob(f'**/{PACKAGE}/__init__.py')
    library = installed.parents[1]
    assert modules(library / PACKAGE) == modules(ROOT / PACKAGE)
    assert not (library / 'test').exists()
    share = prefix / 'share' / PACKAGE
    assert (prefix / 'share/ament_index/resource_index/packages' / PACKAGE).is_file()
    assert (share / 'package.xml').is_file()
    for folder, pattern in (('config', '*.*'), ('launch', '*.launch.py')):
        names = {path.name for path in (ROOT / folder).glob(pattern)}
        assert names
        assert names == {path.name for path in (share / folder).glob('*.*')}
    help_text = subprocess.run(
        [prefix / 'bin' / 'dead-reckoning', '--help'],
        env={**os.environ, 'PYTHONPATH': str(library)},
        cwd=tmp_path,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    assert 'demo' in help_text


def modules(folder):
    return {path.relative_to(folder) for path in folder.rglob('*.py')}
