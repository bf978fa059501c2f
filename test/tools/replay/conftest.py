"""Recordings that tests replay; the work is in `replay_recordings`."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def config(tmp_path):
    """Write settings as a parameter file."""
    import yaml

    def write(**values):
        from replay_recordings import WALKING

        path = tmp_path / 'config.yaml'
        values = {
            key: list(value) if isinstance(value, tuple) else value
            for key, value in (WALKING | values).items()
        }
        path.write_text(yaml.safe_dump({'/**': {'ros__parameters': values}}))
        return path

    return write
