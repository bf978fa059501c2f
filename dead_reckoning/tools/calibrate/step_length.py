"""Step lengths of every model, fitted to recorded walks of known distances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from dead_reckoning.configuration import Configuration, read_values
from dead_reckoning.core import step_lengths
from dead_reckoning.core.errors import InputError, SettingsError
from dead_reckoning.core.pedometer import PedometerSettings
from dead_reckoning.core.pipeline import PEDOMETER, Pipeline
from dead_reckoning.core.step_calibration import AllModels, Fit, fit
from dead_reckoning.sources.recordings import open_recording
from dead_reckoning.tools.replay.progress import Progress
from dead_reckoning.tools.replay.run import flow
from dead_reckoning.tools.replay.summary import Fault, Summary
from dead_reckoning.tools.table import table

NONE = '–'


@dataclass(frozen=True)
class Walk:
    """A recorded walk: its distance [m], its steps, their sizes by model, what was wrong."""

    path: Path
    distance: float
    steps: int
    sizes: dict[str, float]
    faults: dict[str, Fault]


@dataclass(frozen=True)
class Calibration:
    """Every model fitted to some walks, and the settings with the chosen one."""

    walks: Sequence[Walk]
    fits: dict[str, Fit]
    settings: PedometerSettings

    def text(self) -> str:
        """Return a table of the walks and one of the models."""
        walks = [
            (str(w.path), f'{w.distance:g} m', str(w.steps), f'{w.distance / w.steps:.3f} m')
            for w in self.walks
        ]
        models = [
            (
                name,
                f'{found.k:.4f}',
                step_lengths.model(name).UNIT,
                *(
                    f'{100.0 * error:.1f} %' if found.errors else NONE
                    for error in (found.error, found.worst)
                ),
                '← written' if name == self.settings.length_model else '',
            )
            for name, found in self.fits.items()
        ]
        said = [
            table(('recording', 'distance', 'steps', 'each'), walks),
            table(('model', 'k', 'unit', 'error', 'worst', ''), models),
            'error: of the distance of each recording, with the k of the others, mean size'
            if len(self.walks) > 1
            else 'the error of a model takes two recordings to tell, better at two paces',
        ]
        return '\n\n'.join(said)

    def yaml(self) -> str:
        """Return a parameter file of the nodes."""
        distance = sum(walk.distance for walk in self.walks)
        steps = sum(walk.steps for walk in self.walks)
        return (
            f'# Calibrated on {distance:g} m in {steps} steps of pedometer.method '
            f'{self.settings.method}\n'
            '/**:\n'
            '  ros__parameters:\n'
            f'    pedometer.length_model: {self.settings.length_model}\n'
            f'    pedometer.k: {self.settings.k!r}\n'
        ) + (
            f'    pedometer.height: {self.settings.height!r}\n'
            if self.settings.length_model == 'cadence_height'
            else ''
        )


def configured(path: Path | None) -> Configuration:
    """Return the settings of a file, or the defaults, for a chain of a pedometer alone."""
    values = {} if path is None else read_values(path)
    Configuration(values)  # says what is wrong in the rest of the file
    values = {key: value for key, value in values.items() if not key.startswith('pipeline.')}
    return Configuration({**values, 'pipeline.estimators': [PEDOMETER]})


def walk(
    path: Path,
    distance: float,
    configuration: Configuration,
    imu: str | None,
    rate: float | None,
    remaps: Sequence[tuple[str, str]],
) -> Walk:
    """Count the steps of a recording; raises `InputError` where there are none."""
    pipeline = Pipeline(configuration, blocks=True)
    assert pipeline.pedometer is not None
    models = pipeline.pedometer.model = AllModels()
    summary = Summary(pipeline)
    takers = summary.takers()
    try:
        recording = open_recording(path, pipeline.inputs, configuration, imu, rate, dict(remaps))
        with Progress(path.name, recording.length) as progress:
            for name, value in flow(pipeline.chain, recording, progress.add):
                if name in takers:
                    takers[name](value)
    except OSError as error:
        raise InputError(f'{error.filename or path}: {error.strerror or error}') from error
    if not models.sizes:
        raise InputError(f'{path}: no steps in it; pedometer.… of --config says what steps are')
    return Walk(path, distance, len(models.sizes), models.totals(), summary.faults)


def calibrate(
    walks: Sequence[Walk], configuration: Configuration, model: str | None = None
) -> Calibration:
    """Fit every model; choose one by name, else the best, else that of the configuration.

    A tenth of a per cent makes none better.
    Raises `InputError` where the steps would be longer or shorter than any.
    """
    distances = [walk.distance for walk in walks]
    fits = {name: fit(distances, [walk.sizes[name] for walk in walks]) for name in walks[0].sizes}
    settings = configuration[PedometerSettings]
    if model is None:
        model = settings.length_model
        if len(walks) > 1:
            model = min(fits, key=lambda name: (round(fits[name].error, 3), name != model))
    try:
        settings = settings.changed(
            {'pedometer.length_model': model, 'pedometer.k': fits[model].k}
        )
    except SettingsError as error:
        raise InputError(f'{error}; is --distance in metres?') from error
    return Calibration(walks, fits, settings)
