"""Self-contained HTML pages: one look for all of them."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape

STYLE = """
:root { color-scheme: light dark; --text: #222; --soft: #5c5c5c; --line: #ddd; --strong: #888;
        --card: #f6f6f4; --page: #fff; --mark: #c0392b; }
@media (prefers-color-scheme: dark) {
  :root { --text: #e4e4e4; --soft: #a6a6a6; --line: #3a3a3a; --strong: #777; --card: #242424;
          --page: #181818; --mark: #ef7c6e; }
  /* Pictures have no background: their ink turns light and keeps its hues. */
  img { filter: invert(1) hue-rotate(180deg); }
}
body { font: 16px/1.5 system-ui, sans-serif; color: var(--text); background: var(--page);
       max-width: 62em; margin: 2em auto; padding: 0 1.5em; }
h1 { font-weight: 600; margin-bottom: 0; overflow-wrap: anywhere; }
h2 { font-weight: 600; margin: 2em 0 0.3em; }
section { overflow-x: auto; }
p { margin: 0.6em 0; }
.lead { color: var(--soft); margin-top: 0.3em; }
table { border-collapse: collapse; margin: 1em 0; font-variant-numeric: tabular-nums; }
th, td { padding: 0.35em 1.2em 0.35em 0; text-align: right; vertical-align: top;
         border-bottom: 1px solid var(--line); }
th:first-child, td:first-child, .words td, .words th { text-align: left; }
.events td:nth-child(2), .events td:nth-child(3) { white-space: nowrap; }
th { font-weight: 600; border-bottom: 2px solid var(--strong); }
img { width: 100%; display: block; margin: 0.8em 0; }
code { font-size: 0.92em; background: var(--card); padding: 0 0.25em; border-radius: 3px; }
.note { color: var(--soft); font-size: 0.94em; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(10.4em, 1fr));
           gap: 0.8em; margin: 1.5em 0; }
.figures div { background: var(--card); border-radius: 8px; padding: 0.7em 1em; }
.figures dt { color: var(--soft); font-size: 0.88em; }
.figures dd { margin: 0; font-size: 1.3em; font-weight: 600; }
.figures dd small { display: block; font-size: 0.62em; font-weight: 400; color: var(--soft); }
.figures .marked dd { color: var(--mark); }
summary { cursor: pointer; color: var(--soft); }
@media print {
  body { max-width: none; margin: 0; font-size: 11pt; }
  section, .figures div, img, tr { break-inside: avoid; }
  h2 { break-after: avoid; }
}
"""


def document(title: str, parts: Iterable[str]) -> str:
    """Return a page of parts."""
    head = (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width">\n'
        f'<title>{escape(title)}</title><style>{STYLE}</style></head><body>\n'
    )
    return head + '\n'.join(parts) + '\n</body></html>\n'


def image(data: bytes, kind: str, alt: str) -> str:
    """Return a picture that the page holds itself; ``kind`` is png or svg+xml."""
    return f'<img alt="{escape(alt)}" src="data:image/{kind};base64,{b64encode(data).decode()}">'


def table(head: Sequence[str], rows: Iterable[Iterable[str]], kind: str = '') -> str:
    """Return a table of cells of HTML; ``kind`` is its class."""
    lines = [f'<tr>{"".join(f"<th>{cell}</th>" for cell in head)}</tr>']
    lines += [f'<tr>{"".join(f"<td>{cell}</td>" for cell in row)}</tr>' for row in rows]
    begin = f'<table class="{kind}">' if kind else '<table>'
    return begin + '\n'.join(lines) + '</table>'
