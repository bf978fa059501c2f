"""A board that has to be started, and then answers each question with a line."""

from dead_reckoning.sources.serial.protocols.ascii import AsciiDecoder, AsciiSettings


class PolledSettings(AsciiSettings, prefix='driver.serial.polled'):
    """As those of lines."""


class PolledDecoder(AsciiDecoder):
    """Start it, ask it, and tell it when that is over."""

    Settings = PolledSettings
    BITS = 12
    POLLED = True

    def due(self, waited):
        """Say S at the start, then ask."""
        if waited > 1e9:
            return b'S'
        return b'?' if waited > 0.015 else b''

    def goodbye(self):
        """Say Q."""
        return b'Q'


PROTOCOL = PolledDecoder
