"""The pictures of a report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from io import BytesIO
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from dead_reckoning.core.samples import UNMEASURED_VARIANCE
from dead_reckoning.tools.drawing import AXES, RED, tidy
from dead_reckoning.tools.html import image
from dead_reckoning.tools.report import series
from dead_reckoning.tools.report.contents import (
    Accelerations,
    Array,
    Fault,
    Stamps,
    Steps,
    Track,
)

SVG_POINTS = 8000
"""A picture of more points than this is one of pixels."""

REST: Any = {'color': '#8a8a8a', 'alpha': 0.22, 'linewidth': 0.0}
ELLIPSES = 8
"""How many places of a way show their uncertainty."""

ROOM = 3.0
"""How many times larger than the way an ellipse may be that is drawn."""

TALL = 20.0
"""How many times larger than the height's range its uncertainty may be to be drawn in full."""


class Clock:
    """The axis of time that the pictures of a page share: from the first stamp to the last."""

    def __init__(self, start_ns: int, end_ns: int) -> None:
        self.start_ns = start_ns
        self.duration = max((end_ns - start_ns) / 1e9, 1e-3)
        self.unit, self.scale = ('s', 1.0) if self.duration < 600.0 else ('min', 60.0)
        if self.duration > 3.0 * 3600.0:
            self.unit, self.scale = 'h', 3600.0

    def times(self, stamp_ns: Stamps) -> Array:
        """Return times in the unit of the axis."""
        times: Array = series.elapsed(stamp_ns, self.start_ns) / self.scale
        return times

    def words(self, stamp_ns: int) -> str:
        """Say when a stamp was; one from before the start as it is."""
        if stamp_ns < self.start_ns:
            return f'stamp {stamp_ns}'
        return f'{(stamp_ns - self.start_ns) / 1e9 / self.scale:.4g} {self.unit}'

    def finish(self, axes: Axes) -> None:
        """Label the axis."""
        axes.set_xlabel(f'time [{self.unit}]')
        axes.set_xlim(0.0, self.duration / self.scale)


def picture(
    alt: str, draw: Callable[[Sequence[Axes]], int], rows: int = 1, height: float = 3.2
) -> str:
    """Return a picture as HTML; ``draw`` fills its axes and returns how many points it drew."""
    with matplotlib.rc_context({'svg.hashsalt': 'dead_reckoning', 'font.size': 10}):
        figure = Figure(figsize=(9.0, height), layout='constrained')
        axes = list(figure.subplots(rows, 1, sharex=rows > 1, squeeze=False)[:, 0])
        points = draw(axes)
        for each in axes:
            tidy(each)
            if each.get_legend_handles_labels()[0]:
                each.legend(frameon=False, loc='lower right', bbox_to_anchor=(1.0, 0.98), ncols=4)
        file = BytesIO()
        if points <= SVG_POINTS:
            # A date would make each page another one.
            figure.savefig(file, format='svg', transparent=True, metadata={'Date': None})
            return image(file.getvalue(), 'svg+xml', alt)
        figure.savefig(file, format='png', transparent=True, dpi=160)
        return image(file.getvalue(), 'png', alt)


def way(axes: Axes, states: Track) -> int:
    """Draw the way in the plane, to scale, with ellipses of 3 σ; return its points."""
    position = states.position[:, :2]
    shown = series.way(position, series.breaks(states.stamp_ns))
    axes.plot(*shown.T, color=RED, linewidth=1.4, zorder=3)
    axes.plot(*position[0], 'o', color='white', markeredgecolor='black', label='start', zorder=4)
    axes.plot(*position[-1], 'o', color='black', label='end', zorder=4)
    axes.plot([], [], 'o', markersize=9, color=AXES[1], alpha=0.3, label='3 σ')
    extent = max(float(np.ptp(position, axis=0).max()), 1e-3)
    for index in _along(position):
        covariance = in_plane(states, index)
        half, angle = half_axes(covariance)
        if half.max() > ROOM * extent:
            continue
        for ink in ({'alpha': 0.07, 'linewidth': 0.0}, {'fill': False, 'linewidth': 0.6}):
            ellipse = Ellipse(position[index], *2.0 * half, angle=angle, color=AXES[1], **ink)
            axes.add_artist(ellipse)
        spread = 3.0 * np.sqrt(covariance.diagonal())
        axes.update_datalim([position[index] - spread, position[index] + spread])
    axes.update_datalim([position[0] - 0.1 * extent, position[0] + 0.1 * extent])
    axes.autoscale_view()
    axes.set_aspect('equal', adjustable='datalim')
    axes.set_xlabel('x [m]')
    axes.set_ylabel('y [m]')
    return len(shown)


def _along(position: Array) -> list[int]:
    """Return places that are as far from each other along the way, the end among them."""
    gone = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(position, axis=0), axis=1)))
    marks = np.linspace(0.0, gone[-1], ELLIPSES + 1)[1:]
    return sorted({*np.searchsorted(gone, marks).clip(0, len(gone) - 1).tolist(), len(gone) - 1})


def in_plane(states: Track, index: int) -> Array:
    """Return the covariance of x and y at a state, shape (2, 2) [m²]."""
    xx, xy, yy, _ = states.covariance[index]
    return np.array([[xx, xy], [xy, yy]])


def half_axes(covariance: Array) -> tuple[Array, float]:
    """Return half axes of the ellipse of 3 σ [m], the smaller first, and how it is turned [°]."""
    values, vectors = np.linalg.eigh(covariance)
    half = 3.0 * np.sqrt(np.maximum(values, 0.0))
    return half, float(np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0])))


def height(axes: Axes, states: Track, clock: Clock) -> int:
    """Draw the height over time with its σ; return how many points."""
    z = states.position[:, 2]
    sigma = states.sigma[:, 2]
    time, low, high = series.envelope(
        clock.times(states.stamp_ns),
        np.column_stack([z, z - sigma, z + sigma]),
        series.breaks(states.stamp_ns),
    )
    axes.fill_between(
        time, low[:, 1], high[:, 2], color=RED, alpha=0.14, linewidth=0.0, label='±1 σ'
    )
    axes.plot(*series.line(time, low[:, 0], high[:, 0]), color=RED, linewidth=1.2)
    middle = 0.5 * (float(z.min()) + float(z.max()))
    reach = min(float((np.abs(z - middle) + sigma).max()), TALL * max(float(np.ptp(z)), 1e-3))
    axes.set_ylim(middle - 1.06 * reach, middle + 1.06 * reach)
    axes.set_ylabel('height [m]')
    clock.finish(axes)
    return 4 * len(time)


def velocity(axes: Axes, states: Track, clock: Clock) -> int:
    """Draw the velocity over time, rests shaded; return how many points."""
    axes.set_ylabel('velocity [m/s]')
    return rests(axes, states, clock) + _over_time(
        [axes] * 3, states.stamp_ns, states.velocity, clock
    )


def acceleration(
    axes: Sequence[Axes], block: Accelerations, states: Track | None, clock: Clock
) -> int:
    """Draw the linear acceleration over time, an axis in each plot; return how many points.

    Shaded where ``states`` say that the sensor rests.
    """
    points = 0
    for each, axis in zip(axes, 'xyz', strict=True):
        if each is not axes[0]:
            each.sharey(axes[0])  # so that noise does not look like motion
        each.set_ylabel(f'{axis} [m/s²]')
        points += 0 if states is None else rests(each, states, clock)
    return points + _over_time(axes, block.stamp_ns, block.acceleration, clock, names=False)


def _over_time(
    axes: Sequence[Axes],
    stamp_ns: Stamps,
    values: Array,
    clock: Clock,
    names: bool = True,
) -> int:
    """Draw columns over time, each on its axes, those of NaN not; return how many points."""
    time, low, high = series.envelope(clock.times(stamp_ns), values, series.breaks(stamp_ns))
    points = 0
    for k, name in enumerate('xyz'):
        if np.isnan(values[:, k]).all():
            continue
        drawn = series.line(time, low[:, k], high[:, k])
        axes[k].plot(*drawn, color=AXES[k], linewidth=1.0, label=name if names else None)
        points += len(drawn[0])
    clock.finish(axes[-1])
    return points


def rests(axes: Axes, states: Track, clock: Clock) -> int:
    """Shade where the sensor was taken to rest; return how many points."""
    broken = series.breaks(states.stamp_ns)
    spans = series.intervals(clock.times(states.stamp_ns), states.stationary, broken)
    if len(spans):
        axes.broken_barh(spans.tolist(), (0.0, 1.0), transform=axes.get_xaxis_transform(), **REST)
    return 4 * len(spans)


def uncertainty(axes: Axes, states: Track, clock: Clock) -> int:
    """Draw the σ of the position over time, of the axes that are known; return how many points."""
    sigma = states.sigma
    known = sigma.max(axis=0) < 0.999 * UNMEASURED_VARIANCE**0.5
    points = _over_time([axes] * 3, states.stamp_ns, np.where(known, sigma, np.nan), clock)
    axes.set_ylabel('σ of the position [m]')
    axes.set_ylim(bottom=0.0)
    return points


def steps(axes: Sequence[Axes], columns: Steps, clock: Clock) -> int:
    """Draw cadence and length of the steps over time; return how many points."""
    time = clock.times(columns.stamp_ns)
    between = np.diff(columns.stamp_ns) / 1e9
    # Longer than two seconds from step to step is no walk but a rest.
    walking = (between > 0.0) & (between < 2.0)
    cadence = np.full(len(between), np.nan)
    cadence[walking] = 60.0 / between[walking]
    size = 4.0 if len(time) < 2000 else 1.5
    for each, at, values, label, ink in (
        (axes[0], time[1:], cadence, 'cadence [1/min]', AXES[1]),
        (axes[1], time, columns.step_length, 'length [m]', AXES[0]),
    ):
        each.plot(at, values, '.', color=ink, markersize=size)
        each.set_ylabel(label)
        each.set_ylim(0.0, 1.15 * max(float(np.nanmax(values, initial=0.0)), 1e-3))
    clock.finish(axes[1])
    return 20 * len(time)


def faults(axes: Axes, given: Sequence[Fault], clock: Clock) -> int:
    """Draw when something was dropped or found, a row for each class; return how many points."""
    points = 0
    for row, fault in enumerate(given):
        share = (np.array(fault.stamp_ns) - clock.start_ns) / 1e9 / clock.duration
        places = np.unique(np.rint(share * series.COLUMNS)) / series.COLUMNS
        times = places * clock.duration / clock.scale
        axes.plot(times, np.full(len(times), row), '|', color=RED, markersize=11)
        points += 10 * len(times)
    axes.set_yticks(range(len(given)), [fault.kind for fault in given])
    axes.set_ylim(len(given) - 0.4, -0.6)
    clock.finish(axes)
    return points
