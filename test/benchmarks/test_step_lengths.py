"""Step lengths beside those of a person's other bouts, and of simulated walks at other paces."""

import numpy as np
import pytest
from scipy.io import savemat

from benchmarks.accuracy import paces, step_lengths
from dead_reckoning.core.errors import RecordingError

PACE = 1.8
RATE = 100.0


def trial(*walks):
    """Walks, each of so many steps of a length, as sines with a rest before each."""
    norm, bouts = [], []
    for steps, length in walks:
        norm.append(np.full(300, 1.0))
        start = sum(map(len, norm)) / RATE
        time = np.arange(0.0, steps / PACE, 1.0 / RATE)
        norm.append(1.0 + 0.3 * np.sin(2.0 * np.pi * PACE * time))
        bouts.append(
            {
                'Start': start,
                'End': start + steps / PACE,
                'InitialContact_Event': start + np.arange(steps + 1) / PACE,
                'Length': steps * length,
                'Stride_Length': np.array([2.0 * length] * (steps - 2) + [np.nan]),
            }
        )
    norm.append(np.full(300, 1.0))
    force = np.outer(np.concatenate(norm), [0.0, 0.6, -0.8])
    sensor = {'Acc': force, 'Fs': {'Acc': RATE}}
    bouts = np.array(bouts, dtype=object)
    return {'SU': {'LowerBack': sensor}, 'Standards': {'INDIP': {'MicroWB': bouts}}}


def write(folder, name, **tests):
    savemat(folder / f'{name}_data.mat', {'data': {'TimeMeasure1': tests}})
    about = {'TimeMeasure1': {'Height': 170.0}}
    savemat(folder / f'{name}_infoForAlgo.mat', {'infoForAlgo': about})


def test_each_bout_is_judged_by_the_others(tmp_path):
    """Steps of the same force: all models say they are as long as the others'."""
    free = {'Trial1': trial((20, 0.6), (20, 0.5))}
    write(tmp_path, 'P_001', Test5={'Trial1': trial((20, 0.7))}, Test11=free)
    write(tmp_path, 'P_002', Test11={'Trial1': trial((20, 0.5))})  # nothing to judge it by
    report = step_lengths.measure(tmp_path, tmp_path)
    errors = report.figures['errors_percent']
    expected = {'straight': [0.55 / 0.7], 'free': [0.6 / 0.6, 0.65 / 0.5]}
    for name, tolerance in (('constant', 1e-9), ('kim', 3.0)):
        for kind, ratios in expected.items():
            percent = [100.0 * (ratio - 1.0) for ratio in ratios]
            assert errors[name][kind] == pytest.approx(percent, abs=tolerance)
    assert '1 straight, 2 free' in report.text[-1]
    assert report.pictures[0].read_bytes().startswith(b'\x89PNG')


def test_what_is_missing_is_said(tmp_path):
    with pytest.raises(RecordingError, match=r'in it; docs/accuracy\.md says how'):
        step_lengths.measure(tmp_path, tmp_path)
    write(tmp_path, 'P_001', Test11={'Trial1': trial((20, 0.5))})
    with pytest.raises(RecordingError, match='two bouts of nobody'):
        step_lengths.measure(tmp_path, tmp_path)
    (tmp_path / 'P_001_infoForAlgo.mat').unlink()
    with pytest.raises(RecordingError, match='infoForAlgo'):
        step_lengths.measure(tmp_path, tmp_path)


def test_other_paces_are_reported(tmp_path, monkeypatch):
    gait = paces.Gait(1.75, (1.5, 1.75), 0.7, 0.5)
    monkeypatch.setattr(paces, 'GAITS', {'walks': gait})
    monkeypatch.setattr(paces, 'SENSORS', {'one': paces.MMA7260QT})
    report = paces.measure(tmp_path)
    errors = report.figures['walks']
    assert errors['constant']['one'] == pytest.approx([100.0 * ((1.75 / 1.5) ** 0.5 - 1.0), 0.0])
    assert errors['cadence_height']['one'] == pytest.approx([0.0, 0.0], abs=0.5)
    assert [goal.met for goal in report.goals] == [True]
