"""The demo's results as one self-contained HTML page."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import dataclass
from html import escape
from pathlib import Path

from dead_reckoning.tools.demo.cases import Case
from dead_reckoning.tools.demo.recording import Recording
from dead_reckoning.tools.demo.views import Row


@dataclass(frozen=True, eq=False)
class Result:
    """A case, what it recorded, and what came of it."""

    case: Case
    recording: Recording
    rows: list[Row]
    pictures: list[Path]


STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 62em; margin: 2em auto;
       padding: 0 1.5em; }
h1 { font-weight: 600; margin-bottom: 0; } h2 { font-weight: 600; margin-top: 2em; }
.lead { color: #555; margin-top: 0.3em; }
table { border-collapse: collapse; margin: 1em 0; }
th, td { padding: 0.35em 1.2em 0.35em 0; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child { text-align: left; }
th { font-weight: 600; border-bottom: 2px solid #888; }
img { width: 100%; display: block; margin: 0.8em 0; }
code { font-size: 0.92em; background: #f4f4f4; padding: 0 0.25em; }
.note { color: #555; font-size: 0.94em; }
"""


def write(path: Path, results: list[Result]) -> None:
    """Write the page to ``path``, pictures and all."""
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width">',
        f'<title>dead_reckoning: demo</title><style>{STYLE}</style></head><body>',
        '<h1>dead_reckoning</h1>',
        '<p class="lead">Where did the sensor go? Nodes as separate processes over DDS, '
        'set beside the truth of the simulation.</p>',
    ]
    parts += [_section(result) for result in results]
    parts.append('</body></html>\n')
    path.write_text('\n'.join(parts), encoding='utf-8')


def _section(result: Result) -> str:
    case, recording = result.case, result.recording
    counts = ', '.join(
        f'{len(series.time)} on <code>{escape(topic)}</code>'
        for topic, series in recording.series.items()
    )
    pictures = '\n'.join(_picture(path) for path in result.pictures)
    settings = ', '.join(
        f'<code>{escape(k)}: {escape(str(v))}</code>' for k, v in case.parameters.items()
    )
    return f"""
<h2>{escape(case.title)}</h2>
<p>{escape(case.words)}</p>
{table(result.rows)}
{pictures}
<p class="note">{escape(case.view.remark(recording))}</p>
<p class="note">Messages: {counts}.</p>
<p class="note">Settings beyond the defaults: {settings}</p>
"""


def _picture(path: Path) -> str:
    data = b64encode(path.read_bytes()).decode()
    return f'<img alt="{escape(path.stem)}" src="data:image/png;base64,{data}">'


def table(rows: list[Row]) -> str:
    """Return the table of a run as HTML."""
    lines = ''.join(
        '<tr>' + ''.join(f'<td>{escape(cell)}</td>' for cell in row.cells) + '</tr>'
        for row in rows
    )
    return (
        '<table><tr><th></th><th>truth</th><th>estimate</th><th>error</th></tr>'
        + lines
        + '</table>'
    )
