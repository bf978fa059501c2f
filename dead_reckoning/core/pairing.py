"""Bring together what two topics say of one moment."""

from __future__ import annotations

from typing import Generic, TypeVar

from dead_reckoning.core.errors import UnpairedError
from dead_reckoning.core.stamps import RESTART_NS

Left = TypeVar('Left')
Right = TypeVar('Right')


class StampPairs(Generic[Left, Right]):
    """Pair samples of two streams by equal stamps, whichever comes first.

    Each stream keeps its own order, so once a pair is complete, what waits with an earlier arrival
    on either side waits in vain: it is let go, and the next `collect_lost` reports it.  So is
    what the other stream has passed without its stamp.  At most ``limit`` samples wait on a side.
    """

    def __init__(self, limit: int = 2000) -> None:
        self._limit = limit
        self._left: dict[int, Left] = {}
        self._right: dict[int, Right] = {}
        self._lost: list[int] = []

    def left(self, stamp_ns: int, sample: Left) -> tuple[Left, Right] | None:
        """Take a sample of the first stream; return the pair it completes, or None."""
        right = self._right.get(stamp_ns)
        if right is None:
            self._wait(self._left, stamp_ns, sample)
            self._pass(self._right, stamp_ns)
            return None
        self._let_go(self._left)
        self._let_go(self._right, stamp_ns)
        return sample, right

    def right(self, stamp_ns: int, sample: Right) -> tuple[Left, Right] | None:
        """Take a sample of the second stream; return the pair it completes, or None."""
        left = self._left.get(stamp_ns)
        if left is None:
            self._wait(self._right, stamp_ns, sample)
            self._pass(self._left, stamp_ns)
            return None
        self._let_go(self._right)
        self._let_go(self._left, stamp_ns)
        return left, sample

    def collect_lost(self, left_name: str, right_name: str) -> UnpairedError | None:
        """Return an error that counts the samples let go since the last call, or None."""
        if not self._lost:
            return None
        count, first_ns = len(self._lost), self._lost[0]
        self._lost.clear()
        samples = 'sample' if count == 1 else 'samples'
        return UnpairedError(
            f'{count} {samples} from stamp {first_ns} ns on found no partner with the same stamp: '
            f'{left_name} and {right_name} must come from one source; if messages get lost, raise '
            'the depth of the queues or make them reliable (qos_overrides)'
        )

    def _wait(
        self, side: dict[int, Left] | dict[int, Right], stamp_ns: int, sample: object
    ) -> None:
        side[stamp_ns] = sample  # type: ignore[assignment]
        if len(side) > self._limit:
            oldest = next(iter(side))
            del side[oldest]
            self._lost.append(oldest)

    def _pass(self, side: dict[int, Left] | dict[int, Right], stamp_ns: int) -> None:
        """Let go what is older than the other stream, but not what begins after a restart."""
        while side and 0 < stamp_ns - (oldest := next(iter(side))) < RESTART_NS:
            del side[oldest]
            self._lost.append(oldest)

    def _let_go(
        self, side: dict[int, Left] | dict[int, Right], paired_ns: int | None = None
    ) -> None:
        for waiting_ns in list(side):
            del side[waiting_ns]
            if waiting_ns == paired_ns:
                break
            self._lost.append(waiting_ns)
