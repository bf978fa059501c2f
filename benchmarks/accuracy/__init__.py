"""How far off the estimates are on real recordings: ``python -m benchmarks.accuracy DATA``.

A module per kind of recording, listed in `benchmarks.accuracy.__main__`; each says in `PATTERN`
what it looks for under DATA, and `measure` makes a `Report` of one recording.
"""
