"""Settings of a serial port, whatever the board on it sends."""

from __future__ import annotations

from dataclasses import dataclass

from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.serial import protocols


@dataclass(frozen=True, kw_only=True)
class SerialSettings(Settings, prefix='driver.serial'):
    """The serial port of a board, and what the board sends."""

    port: str = parameter(
        '/dev/ttyUSB0',
        'Port of the board; a name under /dev/serial/by-id stays the same wherever it is plugged '
        'in',
    )
    baud: int = parameter(
        115_200, 'Bits per second on the wire, ten of them a byte', unit='1/s',
        minimum=50, maximum=4_000_000,
    )  # fmt: skip
    protocol: str = parameter('ascii', 'What the board sends', choices=protocols.names())
    latency: float = parameter(
        0.0,
        'Time from the measurement to the first bit of its reading on the wire, as far as it is '
        'known; it is taken off the stamps',
        unit='s', minimum=0.0, maximum=10.0,
    )  # fmt: skip

    position_deviation: float = parameter(
        1.0,
        'Standard deviation of x and y of a board that sends positions; none says it itself',
        unit='m', minimum=1e-6, maximum=1e5,
    )  # fmt: skip

    def validate(self) -> None:
        """Raise `SettingsError` for a port that can't be one."""
        if not self.port.strip() or '\0' in self.port:
            raise SettingsError(
                f'driver.serial.port: {self.port!r} is not allowed; the path of a port, as '
                "'/dev/ttyUSB0'"
            )

    @property
    def byte_time(self) -> float:
        """How long a byte is on the wire [s]: start bit, eight bits, stop bit."""
        return 10.0 / self.baud
