"""How a scan, one sample of all channels, lies in the bytes of an industrial-I/O buffer.

Linux, Documentation/ABI/testing/sysfs-bus-iio, *scan_elements*; the alignment is that of
`iio_compute_scan_bytes`: each element at a multiple of its size, the whole one of its largest.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.errors import WrongDeviceError

PATTERN = re.compile(r'(be|le):([su])(\d+)/(8|16|32|64)(?:X(\d+))?>>(\d+)')


@dataclass(frozen=True, slots=True)
class Element:
    """The type of a channel.

    ``bits`` of the value, ``storage`` bits it lies in, ``shift`` of them below it, ``repeat``
    such values one after the other.
    """

    big_endian: bool
    signed: bool
    bits: int
    storage: int
    shift: int
    repeat: int = 1

    @classmethod
    def parse(cls, text: str) -> Element:
        """Read a type, as ``le:s13/16>>0``; raises `WrongDeviceError`."""
        found = PATTERN.fullmatch(text.strip())
        if found is None:
            raise WrongDeviceError(f'{text.strip()!r} is no type of an industrial-I/O channel')
        order, sign, bits, storage, repeat, shift = found.groups()
        if not 0 < int(bits) <= int(storage) - int(shift):
            raise WrongDeviceError(f'{text.strip()!r}: the value is larger than what it lies in')
        return cls(
            order == 'be', sign == 's', int(bits), int(storage), int(shift), int(repeat or 1)
        )

    @property
    def size(self) -> int:
        """Size of one value [bytes]."""
        return self.storage // 8

    def values(self, data: NDArray[np.uint8]) -> NDArray[np.int64]:
        """Return the values, shape (n,), of bytes of shape (n, size)."""
        order = '>' if self.big_endian else '<'
        stored = np.ascontiguousarray(data).view(f'{order}u{self.size}')[:, 0].astype(np.uint64)
        # What is above the value is cut off by the shift up, the sign comes with the shift down.
        up, down = 64 - self.bits - self.shift, 64 - self.bits
        raised = stored << np.uint64(up)
        if self.signed:
            signed: NDArray[np.int64] = raised.view(np.int64) >> np.int64(down)
            return signed
        unsigned: NDArray[np.int64] = (raised >> np.uint64(down)).astype(np.int64)
        return unsigned


class Layout:
    """Where the enabled channels lie in a scan.  ``size`` is that of a scan [bytes]."""

    def __init__(self, elements: Mapping[str, tuple[int, Element]]) -> None:
        """``elements``: name → index and type of each channel that is enabled."""
        self._places: dict[str, tuple[int, Element]] = {}
        end, largest = 0, 1
        for name, (_, element) in sorted(elements.items(), key=lambda item: item[1][0]):
            length = element.size * element.repeat
            start = -(-end // length) * length
            self._places[name] = start, element
            end, largest = start + length, max(largest, length)
        self.size = -(-end // largest) * largest

    def __contains__(self, name: str) -> bool:
        return name in self._places

    def values(self, data: bytes, name: str) -> NDArray[np.int64]:
        """Return the values of a channel, shape (n,), of n whole scans."""
        start, element = self._places[name]
        scans = np.frombuffer(data, np.uint8).reshape(-1, self.size)
        return element.values(scans[:, start : start + element.size])
