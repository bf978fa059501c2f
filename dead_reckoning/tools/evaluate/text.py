"""An evaluation as text, for people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dead_reckoning.tools.evaluate.comparison import Figures
from dead_reckoning.tools.table import table

STATISTICS = ('rmse', 'mean', 'median', 'std', 'min', 'max', 'sse')

ALIGNED = {
    'yaw': 'by heading and translation',
    'se3': 'by rotation and translation',
    'none': 'not at all',
}


def text(evaluation: Figures) -> str:
    """Lay out the figures as tables, each with a line above it that says what it holds."""
    parts = []
    trajectory = evaluation.get('trajectory', {})
    if 'pairs' in trajectory:
        parts += [_errors(trajectory)]
        if trajectory.get('error_over_sigma'):
            parts.append(_consistency(trajectory['error_over_sigma']))
    parts.append(_totals(evaluation))
    return '\n\n'.join(part for part in parts if part)


def _errors(trajectory: Figures) -> str:
    ape, rpe = trajectory['ape'], trajectory['rpe']
    each = f'{rpe["delta"]:g} {rpe["unit"]}'
    lines = [
        ('APE position [m]', ape['translation_m']),
        ('APE rotation [°]', ape['rotation_deg']),
        (f'RPE over {each} [m]', rpe['translation_m']),
        (f'RPE over {each} [°]', rpe['rotation_deg']),
    ]
    return (
        f'{trajectory["file"]}: {trajectory["pairs"]} pairs of {trajectory["samples"]} poses and '
        f'{trajectory["truth"]["samples"]} of the truth, '
        f'aligned {ALIGNED[trajectory["alignment"]["kind"]]}\n'
        + table(
            ('', *STATISTICS),
            [(name, *(f'{values[key]:.4g}' for key in STATISTICS)) for name, values in lines],
        )
    )


def _consistency(axes: Mapping[str, Any]) -> str:
    return 'error / σ of the position; 1 and 99.7 % where σ is right\n' + table(
        ('', 'rms', 'within 3 σ'),
        [(k, f'{v["rms"]:.3g}', f'{100.0 * v["within_3_sigma"]:.1f} %') for k, v in axes.items()],
    )


def _totals(evaluation: Figures) -> str:
    rows = []
    trajectory = evaluation.get('trajectory')
    if trajectory:
        truth = trajectory.get('truth', {})
        for key, name in (
            ('path_length_m', 'length of the way [m]'),
            ('loop_closure_m', 'end from start [m]'),
        ):
            rows.append(_row(name, truth.get(key), trajectory[key]))
    if 'steps' in evaluation:
        steps = evaluation['steps']
        rows.append(_row('steps', steps['truth'], steps['estimate'], digits=0))
    for key, name in (('steps', 'distance by steps [m]'), ('path', 'distance by poses [m]')):
        if key in evaluation.get('distance_m', {}):
            distance = evaluation['distance_m'][key]
            rows.append(_row(name, distance['truth'], distance['estimate']))
    said = table(('', 'truth', 'estimate', 'error', ''), rows)
    if trajectory and 'end_error_m' in trajectory:
        said += f'\n\nThe end is {trajectory["end_error_m"]:.4g} m off.'
    timing = evaluation.get('steps', {}).get('timing')
    if timing and timing['f1'] is not None:
        said += (
            f'\n\n{timing["matched"]} steps within ±{timing["tolerance_s"]:g} s after a lag of '
            f'{timing["lag_s"]:+.3f} s: F1 {timing["f1"]:.3f}'
        )
    return said


def _row(name: str, truth: float | None, estimate: float, digits: int = 3) -> tuple[str, ...]:
    said = f'{estimate:.{digits}f}'
    if truth is None:
        return name, '', said, '', ''
    error = estimate - truth
    percent = f'{100.0 * error / truth:+.1f} %' if truth else ''
    return name, f'{truth:.{digits}f}', said, f'{error:+.{digits}f}', percent
