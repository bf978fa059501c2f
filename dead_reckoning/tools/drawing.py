"""How pictures look: their ink, and as little of it as they need."""

from __future__ import annotations

from matplotlib.axes import Axes

RED = '#c0392b'
AXES = ('#c0392b', '#2e86c1', '#27935a')
"""Ink of x, y and z."""


def tidy(axes: Axes) -> None:
    """Take off what no eye needs."""
    axes.grid(alpha=0.3)
    axes.spines[['top', 'right']].set_visible(False)
