"""An I²C bus of Linux; the one module that knows smbus2."""

from __future__ import annotations

from dead_reckoning.core.errors import DependencyError

try:
    import smbus2
except ImportError as error:
    raise DependencyError(
        'a sensor on an I²C bus needs smbus2: install python3-smbus2, or smbus2 with pip'
    ) from error


class LinuxBus:
    """The bus /dev/i2c-N."""

    def __init__(self, number: int) -> None:
        self._bus = smbus2.SMBus(number)

    def transfer(self, address: int, written: bytes, count: int) -> bytes:
        """Write bytes, then read ``count``, in one transfer; either may be none."""
        messages = [smbus2.i2c_msg.write(address, written)] if written else []
        answer = smbus2.i2c_msg.read(address, count)
        self._bus.i2c_rdwr(*messages, *([answer] if count else []))
        return bytes(answer) if count else b''

    def close(self) -> None:
        """Close the file."""
        self._bus.close()
