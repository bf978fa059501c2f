"""One HTML page about one recording: what came out of it, how sure that is, what was dropped.

``write_report(path, contents)`` writes it.
"""

from dead_reckoning.tools.report.page import write_report

__all__ = ['write_report']
