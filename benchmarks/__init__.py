"""Measurements on recordings that others made; nothing here is installed."""
