"""The Jackal's wheels as ``aiding/odom`` of an inertial navigator, live and called directly.

docs/accuracy.md says what each figure is, and what wheels that spin can tell.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.played import played
from benchmarks.accuracy.report import Report
from benchmarks.accuracy.signals import root_mean_square, rotations
from dead_reckoning import wire
from dead_reckoning.configuration import Configuration, read_values
from dead_reckoning.core.chain import Output
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.samples import ImuSample, NavigationState
from dead_reckoning.core.stages import AIDING_ODOMETRY, IMU, ODOMETRY
from dead_reckoning.topics import topics

Array = NDArray[np.float64]

PRESET = Path(__file__).parents[2] / 'config/vehicle.yaml'

CASES: Mapping[str, Mapping[str, Any]] = {
    'vehicle.yaml': {},
    'rest not learned': {'navigator.zero_rate': False},
    'that, slip 0.3': {'navigator.zero_rate': False, 'navigator.aiding_angle': 0.3},
}
"""What is changed of the preset: its gyro does not learn from rest, as this robot turns there; and
its wheels are wrong by 0.3 of the speed."""


@dataclass(frozen=True)
class Run:
    """States of a navigator, and what it counted."""

    states: list[NavigationState]
    counts: dict[str, int]


def parameters(changed: Mapping[str, Any]) -> dict[str, Any]:
    """Return the preset, with the topic of this Imu and as late as it takes, changed."""
    given = {'navigator.input': IMU, 'navigator.aiding_delay': 10.0}
    return {**read_values(PRESET), **given, **changed}


def navigate(messages: Sequence[tuple[int, str, bytes]], changed: Mapping[str, Any]) -> Run:
    """Put messages into the chain in their order."""
    pipeline = Pipeline(Configuration(parameters(changed)))
    decode = {name: topic.decode for name, topic in topics(FrameSettings()).items()}
    outputs: list[Output] = []
    for _, name, data in messages:
        take = decode[name]
        assert take is not None
        outputs += pipeline.chain.push(name, take(data))
    assert pipeline.navigator is not None
    states = [value for name, value in outputs if name == ODOMETRY]
    return Run(states, pipeline.navigator.counts)


def measure_aiding(
    report: Report, path: Path, imu: str, wheels: str, samples: Sequence[ImuSample]
) -> None:
    """Add what aiding by the wheels does to the navigator of the preset."""
    from benchmarks.accuracy.live import play_aided  # needs ROS, which other recordings do not

    both = {IMU: imu, AIDING_ODOMETRY: wheels}
    messages = played(path, both)
    alone = [one for one in messages if one[1] == IMU]
    runs: dict[str, Run] = {}
    for name, changed in CASES.items():
        runs[f'{name}, alone'] = navigate(alone, changed)
        runs[f'{name}, aided'] = navigate(messages, changed)
    direct = runs['vehicle.yaml, aided'].states
    encode = wire.odometry_encoder('odom', 'base_link')
    live = play_aided(path, both, len(messages), parameters({}))
    last = [wire.decode_odometry(encode(state)) for state in direct[-1:]]
    same = [astuple(own) for own in live[-1:]] == [astuple(own) for own in last] != []
    report.figures['aided_equal_to_direct_chain'] = same
    report.text.append(
        f'  inertial_navigator over DDS, aided by {wheels}: the last of its {len(live)} states is '
        + ('that of the chain called directly, bit for bit' if same else 'ANOTHER than directly')
    )
    if not same:
        report.faults.append('the aided node and the chain called directly end differently')
    by_stamp = {sample.stamp_ns: sample for sample in samples}
    figures = {name: _figures(run, by_stamp) for name, run in runs.items() if run.states}
    report.figures['aided'] = figures
    report.add_table(
        'inertial navigator of vehicle.yaml, without and with the wheels as aiding/odom',
        ('', 'way', 'fastest', 'left at the end', 'tilt off', 'height', 'yaw off', 'taken', 'not'),
        [
            (
                name,
                f'{own["way_m"]:.1f} m',
                f'{own["fastest"]:.2f} m/s',
                f'{own["left_at_the_end"]:.3f} m/s',
                f'{own["tilt_rms_deg"]:.2f}°',
                f'{own["height_m"]:.2f} m',
                f'{own["yaw_deg"]:.0f}°',
                str(own['taken']),
                str(own['refused']),
            )
            for name, own in figures.items()
        ],
    )


def _figures(run: Run, imus: Mapping[int, ImuSample]) -> dict[str, Any]:
    """Return figures of a run against the attitude that the Imu says itself."""
    states = run.states
    said = rotations(np.array([imus[state.stamp_ns].orientation for state in states]))
    found = rotations(np.array([state.attitude for state in states]))
    position = np.array([state.position for state in states])
    velocity = np.array([state.velocity for state in states])
    cosine = np.clip(np.sum(said[:, 2] * found[:, 2], axis=1), -1.0, 1.0)
    yaw = np.unwrap(_yaw(found) - _yaw(said))
    return {
        'way_m': float(np.linalg.norm(np.diff(position, axis=0), axis=1).sum()),
        'fastest': float(np.linalg.norm(velocity, axis=1).max()),
        'left_at_the_end': float(np.linalg.norm(velocity[-1])),
        'tilt_rms_deg': root_mean_square(np.degrees(np.arccos(cosine))),
        'height_m': float(position[-1, 2]),
        'yaw_deg': float(np.degrees(yaw[-1] - yaw[0])),
        'taken': run.counts['aiding_odom'],
        'refused': run.counts['aiding_odom_refused'],
    }


def _yaw(attitudes: Array) -> Array:
    yaw: Array = np.arctan2(attitudes[:, 1, 0], attitudes[:, 0, 0])
    return yaw
