"""Samples, settings, models, estimators and the chain that composes them; no ROS, no clock, no file."""
