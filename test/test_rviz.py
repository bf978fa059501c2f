"""The view for RViz names topics and frames that there are."""

from pathlib import Path

import yaml

from dead_reckoning.core import stages
from dead_reckoning.core.common import FrameSettings

VIEW = Path(__file__).parents[1] / 'rviz' / 'dead_reckoning.rviz'


def test_it_shows_every_odometry_in_the_world_frame():
    manager = yaml.safe_load(VIEW.read_text(encoding='utf-8'))['Visualization Manager']
    shown = [display['Topic']['Value'] for display in manager['Displays'] if 'Topic' in display]
    assert sorted(shown) == sorted([stages.GROUND_TRUTH, stages.ODOMETRY, stages.STEP_ODOMETRY])
    assert manager['Global Options']['Fixed Frame'] == FrameSettings().world
