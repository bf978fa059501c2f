"""Adds the protocols of this folder to those of the package, in whatever process starts here."""

from pathlib import Path

from dead_reckoning.sources.serial import protocols

protocols.__path__.append(str(Path(__file__).parent / 'protocols'))
