"""Pages as a browser without a screen shows them."""

import re
import shutil
import subprocess
import tempfile

import pytest

# Says on the page itself how wide each picture became; 0 where it could not be read.
WIDTHS = """<script>addEventListener('load', () => document.documentElement.dataset.widths =
[...document.images].map(image => image.naturalWidth).join(' '));</script>"""


def opened(path):
    """Return the document of a page and the widths of its pictures; skip where no browser is."""
    browser = shutil.which('chromium') or shutil.which('google-chrome')
    if browser is None:
        pytest.skip('no chromium to open the page with')
    with tempfile.TemporaryDirectory() as folder:
        copy = f'{folder}/page.html'
        with open(copy, 'w', encoding='utf-8') as file:
            file.write(path.read_text(encoding='utf-8') + WIDTHS)
        dumped = subprocess.run(
            [
                browser, '--headless', '--no-sandbox', '--disable-gpu', '--no-first-run',
                '--disable-background-networking', '--disable-sync', '--disable-quic',
                f'--user-data-dir={folder}/profile', '--dump-dom', f'file://{copy}',
            ],
            capture_output=True,
            text=True,
            timeout=60,
            check=True,
        )  # fmt: skip
    widths = re.search('data-widths="([^"]*)"', dumped.stdout)
    return dumped.stdout, [int(width) for width in widths.group(1).split()]


def assert_self_contained(page):
    """Fail where a page would load something from elsewhere."""
    assert not re.search(r'\b(src|href|srcset|data|poster)="(?!data:)', page)
    assert not re.search(r'@import|url\(|<link|<script|<iframe', page)
