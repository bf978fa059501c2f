"""mobgap's example data: a sensor at the lower back, straight and free walking, older persons.

Mobilise-D; the true contacts of the feet are those of INDIP: pressure insoles, sensors on both
feet and distance sensors.  F. Salis et al., "A multi-sensor wearable system for the assessment
of diseased gait in real-world conditions", Front. Bioeng. Biotechnol. 11, 2023, doi
10.3389/fbioe.2023.1143248.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat

from benchmarks.accuracy.report import Report
from benchmarks.accuracy.step_counters import PEDOMETER, Count, Stamps, Walk, count
from benchmarks.accuracy.step_times import against_truth, common_lag, draw_steps
from benchmarks.accuracy.walks import add_variations, percent
from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import NANOSECONDS

Array = NDArray[np.float64]

NAME = 'mobgap'
PATTERN = 'mobgap_lowerback'

ENDING = '_data.mat'

STRAIGHT, FREE = 'Test5', 'Test11'
"""What is measured: some metres straight ahead, and some minutes about a room."""

MOST_STRAIGHT, MOST_FREE = 1, 5.0
"""Goals: steps of a straight walk; per cent of the contacts of a free one."""


@dataclass(frozen=True)
class Bout:
    """Walking without a break, from ``start`` to ``end`` [s since the first sample].

    ``contacts``, shape (n,), are when a foot comes down [s], NaN where that is not known;
    ``length`` [m] is how far it went, and ``strides``, shape (m,), how long each stride is [m],
    NaN where that is not known.
    """

    start: float
    end: float
    contacts: Array
    length: float
    strides: Array

    @property
    def step(self) -> float:
        """The mean time from contact to contact [s]."""
        return (self.end - self.start) / max(len(self.contacts) - 1, 1)


@dataclass(frozen=True)
class Trial:
    """One trial of a person; ``stamps_ns``, shape (n,); ``force_s``, shape (n, 3) [m/s²]."""

    person: str
    test: str
    number: str
    stamps_ns: Stamps
    force_s: Array
    bouts: tuple[Bout, ...]

    @property
    def walk(self) -> Walk:
        """The trial with the contacts of all bouts as the true steps."""
        contacts = np.concatenate([bout.contacts for bout in self.bouts])
        known = contacts[~np.isnan(contacts)]
        landings_ns = self.stamps_ns[0] + np.round(known * NANOSECONDS).astype(np.int64)
        name = f'{self.person} {self.test} {self.number}'
        return Walk(name, len(contacts), self.stamps_ns, self.force_s, landings_ns)

    def inside(self, found_ns: Stamps) -> int:
        """Count the steps from half a step before each bout to half a step after it."""
        found = (found_ns - self.stamps_ns[0]) / NANOSECONDS
        within = [
            (found >= bout.start - 0.5 * bout.step) & (found <= bout.end + 0.5 * bout.step)
            for bout in self.bouts
        ]
        return int(np.sum(within))

    def error(self, found_ns: Stamps) -> float:
        """Return the error of the steps inside: of a straight walk in steps, else in per cent."""
        counted, true = self.inside(found_ns), self.walk.true
        return percent(counted, true) if self.test == FREE else counted - true


def load(path: Path) -> list[Trial]:
    """Read the trials of a person; raises `RecordingError` where something is missing."""
    try:
        tests = loadmat(path, squeeze_me=True, struct_as_record=False)['data'].TimeMeasure1
        return list(_trials(path.name.removesuffix(ENDING), tests))
    except RecordingError:
        raise
    # Of a broken file scipy raises its own errors, which have no common base but this.
    except Exception as error:
        raise RecordingError(f'{path}: {type(error).__name__}, {error}') from error


def _trials(person: str, tests: Any) -> Iterator[Trial]:
    for test in (STRAIGHT, FREE):
        trials = getattr(tests, test, None)
        for number in getattr(trials, '_fieldnames', ()):
            trial = getattr(trials, number)
            sensor = trial.SU.LowerBack
            force_s = GRAVITY * np.asarray(sensor.Acc, dtype=float)
            if force_s.ndim != 2 or force_s.shape[1] != 3 or not np.isfinite(force_s).all():
                raise RecordingError(f'{person}, {test}, {number}: Acc is no force of three axes')
            # A stamp of 0 is none.
            time = 1.0 + np.arange(len(force_s)) / float(sensor.Fs.Acc)
            stamps_ns = np.round(time * NANOSECONDS).astype(np.int64)
            bouts = tuple(
                Bout(
                    float(bout.Start),
                    float(bout.End),
                    np.atleast_1d(np.asarray(bout.InitialContact_Event, dtype=float)),
                    float(bout.Length),
                    np.atleast_1d(np.asarray(bout.Stride_Length, dtype=float)),
                )
                for bout in np.atleast_1d(trial.Standards.INDIP.MicroWB)
                if hasattr(bout, 'Start')  # where there is none, an empty array stands
            )
            yield Trial(person, test, number, stamps_ns, force_s, bouts)


def measure(path: Path, output: Path) -> Report:
    """Measure all trials of all persons of the folder."""
    found = sorted(path.glob(f'*{ENDING}'))
    if not found:
        raise RecordingError(f'{path}: no *{ENDING} in it; docs/accuracy.md says how to get them')
    trials = [trial for person in found for trial in load(person)]
    known = [trial for trial in trials if trial.bouts]
    if not known:
        raise RecordingError(f'{path}: INDIP saw no walking in any trial')
    report = Report('mobgap', f'mobgap, lower back, {len(known)} trials, all settings default')
    counts = [count(trial.walk) for trial in known]
    measured = list(zip(known, counts, strict=True))
    for test, caption in ((STRAIGHT, 'straight walks'), (FREE, 'free walking')):
        some = [each for each in measured if each[0].test == test]
        if some:
            _add(report, caption, some)
    if len(known) < len(trials):
        report.text.append(f'  {len(trials) - len(known)} trials have no true contacts')
    of = {trial.walk.name: trial for trial in known}
    add_variations(
        report,
        [c.walk for c in counts],
        lambda walk, found_ns: of[walk.name].error(found_ns),
        {
            'straight walks [steps]': lambda walk: of[walk.name].test == STRAIGHT,
            'free walking [%]': lambda walk: of[walk.name].test == FREE,
        },
    )
    report.pictures.append(_draw_worst(output / 'mobgap.png', measured))
    return report


def _add(report: Report, caption: str, some: list[tuple[Trial, Count]]) -> None:
    """Add the table of the trials of one test, and its goal."""
    names = list(some[0][1].found)
    rows = []
    errors: dict[str, list[float]] = {name: [] for name in names}
    for trial, counted in some:
        for name in names:
            errors[name].append(trial.error(counted.found[name]))
        inside = [
            f'{trial.inside(counted.found[name])} of {len(counted.found[name])}' for name in names
        ]
        rows.append((f'{trial.person} {trial.number}', str(counted.walk.true), *inside))
    report.add_table(
        f'{caption}: steps within the bouts, of those of the file', ('', 'contacts', *names), rows
    )
    ours = max(map(abs, errors[PEDOMETER]))
    if some[0][0].test == FREE:
        report.aim(f'mobgap, {caption}, worst [%]', ours, MOST_FREE, '{:.1f}')
    else:
        report.aim(f'mobgap, {caption}, worst [steps]', ours, MOST_STRAIGHT, '{:.0f}')
    report.figures[caption] = {
        trial.walk.name: {
            'contacts': counted.walk.true,
            **{
                name: {'inside': trial.inside(stamps_ns), 'in all': len(stamps_ns)}
                for name, stamps_ns in counted.found.items()
            },
        }
        for trial, counted in some
    }


def _draw_worst(path: Path, measured: list[tuple[Trial, Count]]) -> Path:
    """Show the trial with the greatest part of its steps amiss."""
    _, worst = max(
        measured,
        key=lambda each: abs(percent(each[0].inside(each[1].found[PEDOMETER]), each[1].walk.true)),
    )
    lag = common_lag(against_truth([c for _, c in measured], PEDOMETER))
    title = f'mobgap, worst: {worst.walk.name}'
    return draw_steps(path, title, worst.walk, worst.found[PEDOMETER], lag)
