"""Write the report: one self-contained HTML page."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime, timezone
from html import escape
from pathlib import Path
from typing import TypeVar

import numpy as np

from dead_reckoning.core.errors import NotLevelledError
from dead_reckoning.tools import html
from dead_reckoning.tools.report import plots
from dead_reckoning.tools.report.contents import Accelerations, Contents, Fault, Setting, Track
from dead_reckoning.tools.report.plots import Clock, picture
from dead_reckoning.tools.report.series import elapsed

Columns = TypeVar('Columns', Track, Accelerations)

EPOCH_NS = 946_684_800_000_000_000
"""Stamps before the year 2000 count from when a device was switched on, and are no dates."""


def write_report(path: Path, contents: Contents) -> None:
    """Write the page about a recording to ``path``."""
    path.write_text(page(contents), encoding='utf-8')


def page(contents: Contents) -> str:
    """Return the page."""
    clock = _clock(contents)
    return html.document(
        f'dead_reckoning: {contents.name}',
        [
            f'<h1>{escape(contents.name)}</h1>',
            f'<p class="lead">{_lead(contents, clock)}</p>',
            _figures(contents, clock),
            *_sections(contents, clock),
        ],
    )


def _clock(contents: Contents) -> Clock:
    stamps = [
        block.stamp_ns
        for block in (contents.odometry, contents.acceleration, contents.steps, contents.walked)
        if block is not None and len(block.stamp_ns)
    ]
    faults = [stamp for fault in contents.faults for stamp in fault.stamp_ns]
    if not stamps:
        return Clock(min(faults, default=0), max(faults, default=0))
    start = min(int(s[0]) for s in stamps)
    # Stamps may go back, at a restart; time goes on.
    lasts = [start + round(1e9 * float(elapsed(s, start)[-1])) for s in stamps]
    # What was dropped at first came before; a stamp from another age is no beginning.
    begin = [stamp for stamp in faults if 2 * start - max(lasts) < stamp < start]
    return Clock(min(begin, default=start), max(lasts))


def _lead(contents: Contents, clock: Clock) -> str:
    begun = ''
    if clock.start_ns > EPOCH_NS:
        start = datetime.fromtimestamp(clock.start_ns // 10**9, tz=timezone.utc)
        begun = f', from {start:%Y-%m-%d %H:%M:%S} UTC on'
    return (
        f'Replayed by <code>dead-reckoning replay</code>{begun}. World frame: x and y level, z up.'
    )


def _figures(contents: Contents, clock: Clock) -> str:
    """Return the headline figures."""
    states, steps, walked = _filled(contents.odometry), contents.steps, _filled(contents.walked)
    figures = [_figure('duration', duration(clock.duration), *_samples(contents))]
    if states:
        figures += [
            _way_figure(contents, states),
            _figure('end from start', metres(_closure(states)), *_end(states, 3)),
            _figure('at rest', f'{100.0 * np.mean(states.stationary):.0f} %', 'of the samples'),
        ]
    if steps is not None and not len(steps.step):
        figures.append(_figure('steps', '0'))
    elif steps is not None:
        each = f'{steps.step_length.mean():.2f} m each'
        figures += [
            _figure('steps', f'{int(steps.step[-1]):,}', each),
            _figure('distance on foot', metres(float(steps.distance[-1]))),
        ]
    if walked:
        # The way of the steps begins before the first of them.
        from_start = metres(float(np.linalg.norm(walked.position[-1])))
        figures.append(_figure('end from start, on foot', from_start, *_end(walked, 2)))
    dropped = sum(len(fault.stamp_ns) for fault in contents.faults if fault.dropped)
    each = 'counted by each estimator that could not use one'
    # That samples wait for rest at first is as it should be.
    marked = any(f.dropped and f.kind != NotLevelledError.__name__ for f in contents.faults)
    figures.append(
        _figure(
            'dropped', f'{dropped:,}', each if dropped else 'every sample was used', marked=marked
        )
    )
    return f'<dl class="figures">{"".join(figures)}</dl>'


def _way_figure(contents: Contents, states: Track) -> str:
    if contents.strides is None or contents.distance is None:
        return _figure('length of the way', metres(_length(states)), _speed(states))
    each = f'{contents.strides:,} strides'
    return _figure('from stance to stance', metres(contents.distance), each, _speed(states))


def _figure(name: str, value: str, *more: str, marked: bool = False) -> str:
    small = ''.join(f'<small>{escape(words)}</small>' for words in more)
    begin = '<div class="marked">' if marked else '<div>'
    return f'{begin}<dt>{name}</dt><dd>{escape(value)}{small}</dd></div>'


def _sections(contents: Contents, clock: Clock) -> Iterator[str]:
    states, acceleration = _filled(contents.odometry), _filled(contents.acceleration)
    walked, steps = _filled(contents.walked), contents.steps
    if states:
        yield _way('The way', states)
    if walked:
        yield _way('The way on foot', walked)
    if steps is not None and len(steps.step) > 1:
        yield _section(
            'Steps',
            picture('steps over time', lambda a: plots.steps(a, steps, clock), rows=2, height=4.4),
        )
    if states:
        yield _section(
            'Height',
            picture('height over time', lambda a: plots.height(a[0], states, clock)),
            _words_on_height(states),
        )
        yield _section(
            'Velocity',
            picture('velocity over time', lambda a: plots.velocity(a[0], states, clock)),
            'Grey: taken for rest.',
        )
    if acceleration:
        yield _section(
            'Linear acceleration',
            picture(
                'linear acceleration over time',
                lambda a: plots.acceleration(a, acceleration, states, clock),
                rows=3,
                height=5.0,
            ),
            'Gravity is off.'
            + (' Grey: taken for rest, which returns velocity to zero.' if states else ''),
        )
    force = _filled(contents.force)
    if force and not acceleration:
        yield _section(
            'Specific force',
            picture(
                'specific force over time',
                lambda a: plots.acceleration(a, force, states, clock),
                rows=3,
                height=5.0,
            ),
            'Axes of the sensor, gravity is in it. Grey: taken for rest.',
        )
    sure = states or walked
    if sure:
        yield _section(
            'Uncertainty',
            picture('σ of the position over time', lambda a: plots.uncertainty(a[0], sure, clock)),
            'As published: the standard deviation of each coordinate.',
        )
    yield _dropped(contents.faults, clock)
    if contents.notices:
        said = [f'<li>{clock.words(at)}: {escape(words)}</li>' for at, words in contents.notices]
        yield _section('What was said', f'<ul>{"".join(said)}</ul>')
    if contents.settings:
        yield _settings(contents.settings)


def _filled(columns: Columns | None) -> Columns | None:
    return columns if columns is not None and len(columns.stamp_ns) else None


def _way(title: str, states: Track) -> str:
    drawn = picture(f'{title.lower()} in the plane', lambda a: plots.way(a[0], states), height=5.2)
    return _section(title, drawn, _words_on_ellipse(states))


def _section(title: str, *parts: str) -> str:
    """Return a part of the page; a sentence after a picture is a note."""
    body = '\n'.join(
        part if part.startswith('<') else f'<p class="note">{part}</p>' for part in parts if part
    )
    return f'<section><h2>{title}</h2>\n{body}</section>'


def _dropped(faults: Sequence[Fault], clock: Clock) -> str:
    """Return what was dropped and found, why, how often and when."""
    title = 'What was dropped, and why'
    if not faults:
        return _section(title, '<p>Nothing: every sample was used.</p>')
    rows = []
    for fault in faults:
        first, *more = fault.stamp_ns
        when = clock.words(first) + (f' … {clock.words(more[-1])}' if more else '')
        what = f'{1 + len(more):,}' + (' dropped' if fault.dropped else ' ×')
        rows.append((f'<code>{fault.kind}</code>', what, when, escape(fault.words)))
    return _section(
        title,
        html.table(('class', 'samples', 'when', 'the first time it says'), rows, 'words events'),
        picture(
            'when samples were dropped',
            lambda a: plots.faults(a[0], faults, clock),
            height=0.9 + 0.32 * len(faults),
        ),
    )


def _settings(settings: Sequence[Setting]) -> str:
    """Return the settings, those that differ from their defaults first."""

    def rows(chosen: Iterable[Setting]) -> list[tuple[str, ...]]:
        return [
            (
                f'<code>{s.key}</code>',
                f'{escape(s.value)}{f" {s.unit}" if s.unit else ""}',
                escape(s.default),
                escape(s.description),
            )
            for s in chosen
        ]

    head = ('key', 'value', 'default', 'what it is')
    changed = [s for s in settings if s.changed]
    others = [s for s in settings if not s.changed]
    first = html.table(head, rows(changed), 'words') if changed else '<p>All are the defaults.</p>'
    rest = [(*row[:2], row[3]) for row in rows(others)]
    return _section(
        'Settings',
        first,
        f'<details><summary>{len(others)} that are at their defaults</summary>'
        f'{html.table(("key", "value", "what it is"), rest, "words")}</details>'
        if others
        else '',
    )


def _length(states: Track) -> float:
    """Return the length of the way [m], without the jump at a restart."""
    moved = np.linalg.norm(np.diff(states.position, axis=0), axis=1)
    return float(moved[np.diff(states.stamp_ns) > 0].sum())


def _speed(states: Track) -> str:
    return f'at most {np.linalg.norm(states.velocity, axis=1).max():.3g} m/s'


def _closure(states: Track) -> float:
    return float(np.linalg.norm(states.position[-1] - states.position[0]))


def _end(states: Track, axes: int) -> tuple[str, str]:
    at = ', '.join(_rounded(round(v, 3), 3) for v in states.position[-1, :axes].tolist())
    sigma = ', '.join(_rounded(v, 2) for v in states.sigma[-1, :axes].tolist())
    return f'at {at} m', f'σ {sigma} m'


def _rounded(value: float, digits: int) -> str:
    """Return a number with so many digits, or all before its point, and no exponent of ten."""
    said = f'{0.0 + value:.{digits}g}'
    return f'{value:.0f}' if 'e+' in said else said


def _samples(contents: Contents) -> list[str]:
    """Say how many samples there are, and how often they came."""
    words = [f'{contents.samples:,} samples']
    columns = contents.acceleration or contents.odometry
    if columns is not None and len(columns.stamp_ns) > 1:
        period = max(float(np.median(np.diff(columns.stamp_ns))), 1.0)
        words.append(f'{1e9 / period:.4g} Hz')
    return words


def _words_on_ellipse(states: Track) -> str:
    half, _ = plots.half_axes(plots.in_plane(states, -1))
    return (
        'The ellipses are 3 σ: the true place is in them 98.9 times of 100, if σ is right. At the '
        f'end their half axes are {metres(half[1])} and {metres(half[0])}; those more than '
        f'{plots.ROOM:g} times as large as the way are not drawn.'
    )


def _words_on_height(states: Track) -> str:
    z = 0.0 + round(float(states.position[-1, 2]), 3)
    return f'At the end {z:.3f} m, σ {_rounded(states.sigma[-1, 2], 2)} m.'


def metres(value: float) -> str:
    """Return a length in a unit that suits it."""
    if value >= 10_000.0:
        return f'{value / 1000.0:.4g} km'
    return f'{value:.3g} m' if value < 100.0 else f'{value:.0f} m'


def duration(seconds: float) -> str:
    """Return a time as people say it."""
    if seconds < 120.0:
        return f'{seconds:.4g} s'
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f'{hours} h {minutes} min' if hours else f'{minutes} min {rest} s'
