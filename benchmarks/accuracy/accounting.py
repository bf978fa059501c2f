"""Say where each message of a recording went on its way through the nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from benchmarks.accuracy.report import Report
from dead_reckoning.core.samples import LinearAcceleration, NavigationState

GRAVITY, INTEGRATOR = 'gravity_removal', 'integrator'
"""Names of the nodes."""


@dataclass(frozen=True)
class Live:
    """What was published and what came back.

    ``taken`` is how many messages each node took in, ``dropped`` why it dropped samples and how
    often; both as the nodes report on /diagnostics.
    """

    published: int
    accelerations: list[LinearAcceleration]
    states: list[NavigationState]
    taken: dict[str, int]
    dropped: dict[str, dict[str, int]]


def account(report: Report, recorded: int, live: Live) -> None:
    """Say where each message went; those that no one accounts for are a fault."""
    accelerations, states = len(live.accelerations), len(live.states)
    dropped = {node: sum(live.dropped[node].values()) for node in live.dropped}
    missing = {
        'published': recorded - live.published,
        f'taken in by {GRAVITY}': live.published - live.taken[GRAVITY],
        'linear accelerations received': live.taken[GRAVITY] - dropped[GRAVITY] - accelerations,
        f'taken in by {INTEGRATOR}': live.published + accelerations - live.taken[INTEGRATOR],
        # The integrator refuses each Imu that gravity removal refuses, and perhaps others.
        'odometries received': live.published - dropped[INTEGRATOR] - states,
    }
    rows = [
        ('in the bag', str(recorded)),
        ('published with their own stamps', str(live.published)),
        (f'taken in by {GRAVITY}', str(live.taken[GRAVITY])),
        (f'dropped by {GRAVITY}', _reasons(live.dropped[GRAVITY])),
        ('linear accelerations received', str(accelerations)),
        (f'taken in by {INTEGRATOR} (attitude, acceleration)', str(live.taken[INTEGRATOR])),
        (f'dropped by {INTEGRATOR}', _reasons(live.dropped[INTEGRATOR])),
        ('odometries received', str(states)),
        ('unaccounted for', str(sum(abs(count) for count in missing.values()))),
    ]
    report.add_table('messages over DDS', ('', ''), rows)
    report.figures['messages'] = {
        'recorded': recorded,
        'published': live.published,
        'taken': live.taken,
        'dropped': live.dropped,
        'accelerations': accelerations,
        'odometries': states,
        'unaccounted': missing,
    }
    report.faults += [
        f'{count:+d} messages are not accounted for: {where}'
        for where, count in missing.items()
        if count
    ]


def _reasons(dropped: Mapping[str, int]) -> str:
    return ', '.join(f'{count} {kind}' for kind, count in dropped.items()) or '0'
