"""Step lengths at the lower back: each model, calibrated on other walks of the same person."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat

from benchmarks.accuracy import pictures
from benchmarks.accuracy.mobgap import ENDING, FREE, PATTERN, STRAIGHT, Bout, Trial, load
from benchmarks.accuracy.report import Report
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.pedometer import Pedometer, PedometerSettings
from dead_reckoning.core.samples import NANOSECONDS, ImuSample
from dead_reckoning.core.step_calibration import AllModels, Fit, fit

__all__ = ['NAME', 'PATTERN', 'judged', 'measure']

Array = NDArray[np.float64]

NAME = 'step lengths'

PERSON = '_infoForAlgo.mat'
"""Ends the name of the file that has a person's height."""

KINDS = {STRAIGHT: 'straight', FREE: 'free'}

ALIKE = 'straight, k from straight'

DRAWN = ('constant', 'kim', 'an900_equation2')


@dataclass(frozen=True)
class Walked:
    """A bout: how its steps were, and what the models make of them.

    ``length``
        of its strides in the mean, half of it [m].
    ``steps``
        how many there were.
    ``sizes``
        of the steps that were counted in it, in the mean, by model.
    """

    kind: str
    length: float
    steps: int
    sizes: dict[str, float]


def measure(path: Path, output: Path) -> Report:
    """Measure all persons of the folder."""
    found = sorted(path.glob(f'*{ENDING}'))
    if not found:
        raise RecordingError(f'{path}: no *{ENDING} in it; docs/accuracy.md says how to get them')
    walked = [_walked(file) for file in found]
    persons = [bouts for bouts in walked if len(bouts) > 1]
    if not persons:
        raise RecordingError(f'{path}: steps were counted in two bouts of nobody')
    settings = PedometerSettings()
    report = Report(
        'step_lengths',
        f'Step lengths at the lower back, {len(found)} persons, steps by {settings.method}',
    )
    errors: dict[str, dict[str, list[float]]] = {}
    drawn: dict[str, list[tuple[float, float]]] = {}
    rows = []
    for name in AllModels().names:
        ks = []
        kinds: dict[str, list[float]] = {kind: [] for kind in (*KINDS.values(), ALIKE)}
        for bouts in persons:
            fitted = _fit(bouts, name)
            ks.append(f'{fitted.k:.2f}')
            for bout, error in zip(bouts, fitted.errors, strict=True):
                kinds[bout.kind].append(100.0 * error)
                drawn.setdefault(name, []).append((bout.length, bout.length * (1.0 + error)))
            straight = [bout for bout in bouts if bout.kind == KINDS[STRAIGHT]]
            if len(straight) > 1:
                kinds[ALIKE] += [100.0 * error for error in _fit(straight, name).errors]
        errors[name] = kinds
        rows.append(
            (
                f'{name}{" (default)" if name == settings.length_model else ""}',
                ', '.join(ks),
                *(_said(np.abs(of_one)) for of_one in kinds.values()),
            )
        )
    report.add_table(
        'error of the length of a step, mean of a bout, k from all other bouts of the person:\n'
        'mean size (worst)',
        ('', 'k of each', *KINDS.values(), ALIKE),
        rows,
    )
    kinds = errors[settings.length_model]
    said = ', '.join(f'{len(kinds[kind])} {kind}' for kind in KINDS.values())
    report.text.append(f'  bouts of {len(persons)} persons with counted steps in two: {said}')
    report.figures['errors_percent'] = errors
    report.pictures.append(_draw(output / 'step_lengths.png', report.title, drawn))
    return report


def _fit(bouts: Sequence[Walked], name: str) -> Fit:
    distances = [bout.steps * bout.length for bout in bouts]
    return fit(distances, [bout.steps * bout.sizes[name] for bout in bouts])


def _said(sizes: Array) -> str:
    return f'{np.mean(sizes):.1f} % ({np.max(sizes):.1f} %)' if len(sizes) else '–'


def judged(samples: Iterable[ImuSample], height: float = 1.7) -> AllModels:
    """Return what each model makes of the steps that the defaults find."""
    parts = Configuration({'pedometer.height': height})
    settings = parts[PedometerSettings]
    pedometer = Pedometer(settings, parts[settings.method_part])
    models = pedometer.model = AllModels()
    for imu in samples:
        pedometer.update(imu)
    return models


def _walked(path: Path) -> list[Walked]:
    """Return the bouts of a person in which steps were counted."""
    person = path.with_name(path.name.removesuffix(ENDING) + PERSON)
    try:
        about = loadmat(person, squeeze_me=True, struct_as_record=False)['infoForAlgo']
        height = float(about.TimeMeasure1.Height) / 100.0
    except (OSError, KeyError, AttributeError, ValueError) as error:
        raise RecordingError(f'{person}: {error}') from error
    return [walked for trial in load(path) for walked in _bouts(trial, height)]


def _bouts(trial: Trial, height: float) -> list[Walked]:
    rows = zip(trial.stamps_ns.tolist(), trial.force_s.tolist(), strict=True)
    models = judged((ImuSample(stamp, 'imu_link', (x, y, z)) for stamp, (x, y, z) in rows), height)
    stamps_ns, sizes = np.array(models.stamps_ns), np.array(models.sizes)
    time = (stamps_ns - trial.stamps_ns[0]) / NANOSECONDS
    return [
        Walked(
            KINDS[trial.test],
            float(np.nanmean(bout.strides)) / 2.0,
            len(bout.contacts) - 1,
            dict(zip(models.names, sizes[inside].mean(axis=0).tolist(), strict=True)),
        )
        for bout in trial.bouts
        if (inside := _inside(bout, time)).any()
    ]


def _inside(bout: Bout, time: Array) -> NDArray[np.bool_]:
    """Say which steps are from half a step before a bout to half a step after it."""
    margin = 0.5 * bout.step
    return (time >= bout.start - margin) & (time <= bout.end + margin)


def _draw(path: Path, title: str, drawn: dict[str, Sequence[tuple[float, float]]]) -> Path:
    """Show the judged length of the steps of each bout over the true one."""
    figure, axes = pictures.one(title)
    for name, colour in zip(DRAWN, pictures.RUNS, strict=True):
        true, found = zip(*drawn[name], strict=True)
        axes.plot(true, found, 'o', color=colour, label=name)
    axes.axline((0.4, 0.4), slope=1.0, **pictures.TRUTH)
    axes.set_xlabel('true length of a step, mean of a bout [m]')
    axes.set_ylabel('judged, k from other bouts [m]')
    pictures.legend_above(axes)
    return pictures.save(figure, path)
