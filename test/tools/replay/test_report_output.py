"""The report among the outputs of a replay, and the evaluation of what a replay wrote."""

import json

import pytest
from browser import assert_self_contained, opened
from replay_recordings import RAW, STEPS, headings, spoiled, walk, write_bag

from dead_reckoning.tools.main import main


def test_report_of_a_replay_and_its_evaluation(tmp_path, config):
    recording = write_bag(tmp_path / 'walk', headings(spoiled(walk())))
    folder = tmp_path / 'out'
    options = ['--config', str(config()), '--output', str(folder)]
    assert main(['replay', str(recording), *options]) == 0
    assert_self_contained((folder / 'report.html').read_text(encoding='utf-8'))
    document, widths = opened(folder / 'report.html')
    assert f'<title>dead_reckoning: {recording.name}</title>' in document
    assert min(widths) > 0
    summary = json.loads((folder / 'summary.json').read_text())
    assert f'<small>{summary["samples"]:,} samples</small>' in document
    assert f'<dt>steps</dt><dd>{summary["steps"]}<small>' in document
    for kind, count in summary['dropped'].items():
        assert f'<code>{kind}</code></td><td>{count:,} dropped</td>' in document

    truth = ['--truth', str(folder / 'odometry.csv'), '--align', 'none']
    assert main(['evaluate', str(folder), *truth, '--steps', str(STEPS)]) == 0
    evaluation = json.loads((folder / 'evaluation.json').read_text())
    assert evaluation['trajectory']['ape']['translation_m']['max'] == 0.0
    assert evaluation['trajectory']['path_length_m'] == pytest.approx(summary['path_length_m'])
    assert evaluation['steps'] == {
        'truth': STEPS,
        'estimate': summary['steps'],
        'error': summary['steps'] - STEPS,
        'error_percent': pytest.approx(100.0 * (summary['steps'] - STEPS) / STEPS),
    }


def test_only_the_report(tmp_path, config):
    recording = write_bag(tmp_path / 'walk', ((RAW, sample) for sample in walk()[:200]))
    options = ['--config', str(config()), '--output', str(tmp_path / 'out')]
    assert main(['replay', str(recording), *options, '--outputs', 'report']) == 0
    assert [path.name for path in (tmp_path / 'out').iterdir()] == ['report.html']
