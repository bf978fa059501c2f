"""Take messages as bytes, and give the state back to the estimators where they need it.

Between regular messages what estimators have no array of their own for is in one
(`core.kernels.memory`), and they are behind.  Whoever needs them lets it be carried back first:
`LiveChain.settle`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from dead_reckoning import wire
from dead_reckoning.block_wire import doubles_at
from dead_reckoning.core.chain import Chain, Output
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.kernels import memory as layout
from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.samples import NANOSECONDS, ZERO, NavigationState
from dead_reckoning.core.stages import ODOMETRY_MESSAGE
from dead_reckoning.live.steps import LiveSteps

WAIT = 50
"""Messages that go through the stream after one that had to: to give the state back and to take it
over anew costs as much as five of them."""

TEXT_AT = 16
"""Where the frame id stands in a message; four bytes before it, its length."""


class LiveChain(Chain, ABC):
    """Do with kernels what the chain of a `Pipeline` does with a regular message.

    Regular is what the kernels for blocks take, of one frame, by the encoding of this machine.
    Anything else, `push` takes, as does each chain.
    """

    KERNELS: ClassVar[tuple[tuple[Callable[..., Any], tuple[Any, ...]], ...]]
    """The kernels that it calls, each with arguments for which it can be compiled."""

    BESIDE: ClassVar[Collection[str]] = ()
    """What may be pushed while the estimators are behind."""

    def __init__(self, pipeline: Pipeline, frames: FrameSettings, taken: str) -> None:
        """Take a pipeline, and the topic that `taken_of` names."""
        super().__init__(pipeline.stages)
        self.ready = False
        """Whether `KERNELS` are compiled; whoever sees to that says so here."""
        self.taken = 0
        """Messages that were taken by kernels."""
        self._rest = pipeline.rest
        self._input = taken
        self._steps = LiveSteps(pipeline, taken)
        encode = wire.odometry_encoder(frames.world, frames.body)
        self._written = encode(NavigationState(0, ZERO, ZERO))
        self._memory: Array | None = None
        self._waiting = 0

    @staticmethod
    @abstractmethod
    def taken_of(pipeline: Pipeline) -> str | None:
        """Name the topic that kernels take for a pipeline; None: they can't do what it does."""

    @classmethod
    def compile(cls) -> None:
        """Have the kernels compiled, and kept for the next run."""
        for kernel, arguments in cls.KERNELS:
            kernel(*arguments)

    @abstractmethod
    def _regular_since(self) -> tuple[int, float] | None:
        """Return the last stamp [ns] and the longest step [s], if its estimators are regular."""

    @abstractmethod
    def _parts(self) -> Mapping[int, NDArray[Any]] | None:
        """Return what its kernels find in the memory; None where they can't."""

    @abstractmethod
    def _run(self, memory: Array) -> list[Output] | None:
        """Take the Imu that lies in the memory; None says that it is not regular."""

    @abstractmethod
    def _leave(self, memory: Array, last_ns: int) -> None:
        """Carry the state back."""

    def push(self, name: str, sample: Any) -> list[Output]:
        """Put one sample in under its name; return all outputs it caused, in order."""
        if self._memory is not None and name not in self.BESIDE:
            self.settle()
            self._waiting = WAIT
        return super().push(name, sample)

    def take(self, name: str, data: bytes) -> list[Output] | None:
        """Put in a message as its bytes; None says that it is for `push`, and nothing changed."""
        if name != self._input or not self.ready:
            return None
        memory = self._memory
        if memory is None and (memory := self._take_over(data)) is None:
            return None
        if (
            len(data) != len(self._imu)
            or data[TEXT_AT - 4 : self._text_end] != self._text
            or data[:2] != wire.LITTLE_ENDIAN[:2]
        ):
            return None
        self._imu[:] = data
        outputs = self._run(memory)
        if outputs is not None:
            self.taken += 1
        return outputs

    def settle(self) -> None:
        """Let the estimators hold their state: someone looks at it, or is going to change it."""
        memory, self._memory = self._memory, None
        if memory is not None:
            self._leave(memory, int(self._clock[layout.LAST]))
            self._steps.leave(memory)

    def _state(self, rests: bool) -> list[Output]:
        """Return what comes of the state that was written as Odometry."""
        return [(ODOMETRY_MESSAGE, self._odometry.tobytes()), *self._rest.of(rests)]

    def _take_over(self, data: bytes) -> Array | None:
        """Take the state over from the estimators, for messages like this one, if that goes."""
        if self._waiting:
            self._waiting -= 1
            return None
        length = int.from_bytes(data[TEXT_AT - 4 : TEXT_AT], 'little')
        parts = self._all_parts()
        fits = len(data) == doubles_at(length) + 8 * layout.IMU_DOUBLES
        if parts is None or not fits:
            self._waiting = WAIT
            return None
        self._text_end = TEXT_AT + length
        self._text = data[TEXT_AT - 4 : self._text_end]
        messages = {layout.IMU: _words(data), layout.ODOMETRY: _words(self._written)}
        self._memory = memory = layout.packed({**messages, **parts})
        self._imu, self._odometry = (
            memoryview(layout.part(memory, number)).cast('B')[4:]  # type: ignore[arg-type]
            for number in messages
        )
        self._clock = layout.ticks(memory, layout.CLOCK)
        self._steps.begin(memory)
        return memory

    def _all_parts(self) -> dict[int, NDArray[Any]] | None:
        """Return what a memory holds besides messages; None where the stream is at work."""
        since = self._regular_since()
        if since is None:
            return None
        last_ns, longest = since
        clock = np.zeros(layout.TAIL + 1, np.int64)
        clock[layout.LAST], clock[layout.LONGEST] = last_ns, int(longest * NANOSECONDS)
        of_steps = self._steps.parts(clock)
        parts = None if of_steps is None else self._parts()
        if of_steps is None or parts is None:
            return None
        return {layout.CLOCK: clock, **parts, **of_steps}


def _words(message: bytes) -> Array:
    """Return a message from four bytes before it on, which aligns its doubles."""
    return np.frombuffer(bytes(4) + message)
