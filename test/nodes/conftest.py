"""Fixtures for tests with real nodes; the work is in `ros_harness`."""

import sys
from pathlib import Path

import pytest
from hypothesis import settings

sys.path.insert(0, str(Path(__file__).parent))

# Whoever imports them has these protocols, as pytest would in its search for doctests.
collect_ignore = ['fake_protocols']

settings.register_profile('repeatable', derandomize=True, database=None, deadline=None)
settings.load_profile('repeatable')


@pytest.fixture
def ros(domain_id, tmp_path):
    """Give a test a ROS node, and the means to start others, in a domain of its own."""
    from ros_harness import Ros

    with Ros(domain_id, tmp_path) as ros:
        yield ros


@pytest.fixture(scope='module')
def module_ros(module_domain_id, tmp_path_factory):
    """Give the tests of a module a ROS node and processes they share."""
    from ros_harness import Ros

    with Ros(module_domain_id, tmp_path_factory.mktemp('ros')) as ros:
        yield ros


@pytest.fixture(scope='session', autouse=True)
def _kernels():
    """Compile what the inertial navigator needs, which may take longer than a node has here."""
    from dead_reckoning.core.common import CommonSettings
    from dead_reckoning.core.navigation.settings import NavigatorSettings
    from dead_reckoning.core.navigator_stage import load_kernels

    load_kernels(NavigatorSettings(), CommonSettings())
