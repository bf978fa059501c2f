"""Samples, settings, models, estimators and the chain of them; no ROS, no clock, no file."""
