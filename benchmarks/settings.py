"""What half and twice of each setting cost on recordings: ``python -m benchmarks.settings DATA``.

Those of the preset `foot_mounted`, and what it costs to leave a part out.  DATA is that of `make
accuracy`; docs/navigation.md, "Settings", has the figures.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy import gaitmap, gcp, openshoe, xio
from benchmarks.accuracy.inertial import FOOT, HELD, in_blocks
from benchmarks.accuracy.signals import root_mean_square
from dead_reckoning.configuration import NAVIGATOR
from dead_reckoning.tools.table import table

Array = NDArray[np.float64]

PREFIX = 'navigator.'

SETTINGS = (
    'averaging', 'acceleration_noise', 'sampling_noise', 'rate_noise', 'rate_walk', 'rate_bias',
    'acceleration_bias', 'acceleration_walk', 'stance_velocity', 'pivot', 'height', 'correlation',
    'sway', 'still_window', 'still_deviation', 'shoe.share', 'shoe.least', 'rest_factor',
    'shoe.weight', 'memory', 'window', 'minimum', 'floor_deviation',
)  # fmt: skip
"""What is halved, as far as it may be, and doubled."""

OTHERWISE: Mapping[str, Mapping[str, Any]] = {
    'σ_a and κ of the sensor': {'acceleration_noise': 0.002, 'sampling_noise': 0.0},
    'velocity of white noise': {'stance_velocity': 0.02, 'correlation': 0.004, 'pivot': 0.0},
    'no pivot': {'pivot': 0.0},
    'no rate at rest': {'zero_rate': False},
    'no bias of the accelerometer': {'acceleration_bias': 0.0},
    'no floor': {'floor': False},
    'rate_scale as in a hand': {'rate_scale': HELD['navigator.rate_scale']},
}
"""What is left out, or modelled otherwise; white noise is that of 2 cm/s at 250 Hz."""

FIGURES = ('OpenShoe %', 'worst', 'GCP m', 'worst', 'gaitmap m', 'x-io m')
"""As docs/accuracy.md has them: errors at the end, median and worst; RMSE of a stride's length;
error at the end in three dimensions."""


class Feet:
    """Recordings of feet; all four sets must be there."""

    def __init__(self, data: Path) -> None:
        """Read them; raises `RecordingError` where one is not as it should be."""
        self._loops = [openshoe.load(path) for path in sorted(data.glob('openshoe/*.npz'))]
        self._walks = [gcp.read(path) for path in sorted(data.glob('koroglu_gcp/*.npz'))]
        self._strides = [gaitmap.load(data / gaitmap.PATTERN, foot) for foot in gaitmap.FEET]
        self._short = xio.load(data / 'xio_gait_tracking/short_walk.csv.gz')

    def measure(self, changed: Mapping[str, Any]) -> tuple[Array, int]:
        """Navigate with settings changed; return `FIGURES`, and strides of GCP miscounted."""
        values = {**FOOT, **{PREFIX + name: value for name, value in changed.items()}}
        loops = [in_blocks(loop, values) for loop in self._loops]
        percents = [100.0 * np.hypot(*way.end[:2]) / way.length for way in loops]
        walks = [(in_blocks(walk, values), int(true)) for walk, (_, _, true, _) in self._walks]
        ends = [np.hypot(*way.end[:2]) for way, _ in walks]
        errors = []
        for recording, borders, true in self._strides:
            way = in_blocks(recording, values)
            at = gaitmap.in_states(way, borders)
            errors.append(gaitmap.lengths_between(way.states.position, at) - true)
        figures = (
            np.median(percents),
            max(percents),
            np.median(ends),
            max(ends),
            root_mean_square(np.concatenate(errors)),
            np.linalg.norm(in_blocks(self._short, values).end),
        )
        return np.array(figures), sum(abs(way.strides - true) for way, true in walks)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog='python -m benchmarks.settings', description=__doc__)
    parser.add_argument('data', type=Path, help='folder of the recordings: docs/accuracy.md')
    feet = Feet(parser.parse_args().data)
    default, _ = feet.measure({})
    rows = []
    for name, changed in _changes():
        figures, miscounted = feet.measure(changed)
        times = zip(figures, figures / default, strict=True)
        rows.append((name, *(f'{own:.3f} ×{ratio:.2f}' for own, ratio in times), str(miscounted)))
    print(table(('', *FIGURES, 'strides off'), rows))


def _changes() -> Iterator[tuple[str, Mapping[str, Any]]]:
    yield 'default', {}
    known = {p.key.removeprefix(PREFIX): p for part in NAVIGATOR for p in part.parameters()}
    for name in SETTINGS:
        own = known[name]
        assert isinstance(own.default, float)
        for times in (0.5, 2.0):
            yield f'{name} × {times:g}', {name: max(own.minimum, times * own.default)}
    yield from OTHERWISE.items()


if __name__ == '__main__':
    main()
