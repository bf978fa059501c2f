"""A board that says where it is: x and y in the first two columns."""

from dead_reckoning.core.stages import AN3397
from dead_reckoning.sources.serial.protocols import Position, Reading
from dead_reckoning.sources.serial.protocols.ascii import AsciiDecoder, AsciiSettings


class PlacesSettings(AsciiSettings, prefix='driver.serial.places'):
    """As those of lines."""


class PlacesDecoder(AsciiDecoder):
    """Take readings for positions."""

    Settings = PlacesSettings
    OUTPUT = AN3397

    def feed(self, data):
        """Make positions of readings."""
        return [
            Position(*event.values[:2], event.start) if isinstance(event, Reading) else event
            for event in super().feed(data)
        ]


PROTOCOL = PlacesDecoder
