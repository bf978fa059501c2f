"""The demo's results as one self-contained HTML page."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from pathlib import Path

from dead_reckoning.tools import html
from dead_reckoning.tools.demo.cases import Case
from dead_reckoning.tools.demo.recording import Recording
from dead_reckoning.tools.demo.views import Row

HEAD = ('', 'truth', 'estimate', 'error')


@dataclass(frozen=True, eq=False)
class Result:
    """A case, what it recorded, and what came of it."""

    case: Case
    recording: Recording
    rows: list[Row]
    pictures: list[Path]


def write(path: Path, results: list[Result]) -> None:
    """Write the page to ``path``, pictures and all."""
    lead = (
        'Where did the sensor go? Nodes as separate processes over DDS, set beside the truth of '
        'the simulation.'
    )
    parts = ['<h1>dead_reckoning</h1>', f'<p class="lead">{lead}</p>', *map(_section, results)]
    path.write_text(html.document('dead_reckoning: demo', parts), encoding='utf-8')


def _section(result: Result) -> str:
    case, recording = result.case, result.recording
    counts = ', '.join(
        f'{len(series.time)} on <code>{escape(topic)}</code>'
        for topic, series in recording.series.items()
    )
    pictures = '\n'.join(html.image(p.read_bytes(), 'png', p.stem) for p in result.pictures)
    settings = ', '.join(
        f'<code>{escape(k)}: {escape(str(v))}</code>' for k, v in case.parameters.items()
    )
    return f"""
<h2>{escape(case.title)}</h2>
<p>{escape(case.words)}</p>
{html.table(HEAD, [map(escape, row.cells) for row in result.rows])}
{pictures}
<p class="note">{escape(case.view.remark(recording))}</p>
<p class="note">Messages: {counts}.</p>
<p class="note">Settings beyond the defaults: {settings}</p>
"""
