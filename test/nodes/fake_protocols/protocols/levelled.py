"""A board that measures its attitude and its rate of turn, too."""

from dataclasses import replace

from dead_reckoning.core.stages import IMU
from dead_reckoning.sources.serial.protocols import Reading
from dead_reckoning.sources.serial.protocols.ascii import AsciiDecoder, AsciiSettings


class LevelledSettings(AsciiSettings, prefix='driver.serial.levelled'):
    """As those of lines."""


class LevelledDecoder(AsciiDecoder):
    """Turned to the north, and turning on."""

    Settings = LevelledSettings
    OUTPUT = IMU

    def feed(self, data):
        """Add what lines do not say."""
        north = {'rate': (0.0, 0.0, 0.5), 'orientation': (0.0, 0.0, 0.6, 0.8)}
        return [replace(e, **north) if isinstance(e, Reading) else e for e in super().feed(data)]


PROTOCOL = LevelledDecoder
