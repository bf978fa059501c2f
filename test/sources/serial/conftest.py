"""Hypothesis finds the same examples every time, and takes the time it needs."""

from hypothesis import settings

settings.register_profile('repeatable', derandomize=True, database=None, deadline=None)
settings.load_profile('repeatable')
