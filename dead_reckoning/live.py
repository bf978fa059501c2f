"""Run a chain on messages as they come: compiled where they are regular, else like any chain.

Between regular messages the state is in one array (`core.kernels.memory`), and the estimators are
behind.  Whoever needs them lets it be carried back first: `LiveChain.settle`.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dead_reckoning import wire
from dead_reckoning.block_wire import doubles_at
from dead_reckoning.core.attitude.held import HeldAttitude
from dead_reckoning.core.attitude.message import MessageAttitude
from dead_reckoning.core.batch import gravity, integrator, pedometer
from dead_reckoning.core.chain import Chain, Output
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.headings import Heading
from dead_reckoning.core.kernels import memory as layout
from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.kernels.headings import HeadingColumns
from dead_reckoning.core.kernels.live import CELL, HEADS, IRREGULAR, RESTS
from dead_reckoning.core.mounting import mountings_of
from dead_reckoning.core.parameters import Parts
from dead_reckoning.core.pipeline import Pipeline, PipelineSettings
from dead_reckoning.core.rotation import NO_ROTATION
from dead_reckoning.core.samples import IDENTITY_QUATERNION, NANOSECONDS, ZERO, NavigationState
from dead_reckoning.core.stages import IMU, ODOMETRY_MESSAGE, gravity_input

WAIT = 50
"""Messages that go through the stream after one that had to: to give the state back and to take it
over anew costs as much as five of them."""

TEXT_AT = 16
"""Where the frame id stands in a message; four bytes before it, its length."""

LONGEST_STEP = 1.0
"""Longest time [s] between samples for which the kernel has room."""

HEADED = {'orientation': layout.REQUIRED, 'any': layout.WELCOME}
"""What an orientation is for `pedometer.heading`."""

LEVELLED_WIDTHS = (3, 9, 9, 4, 9)
STATE_WIDTHS = (3, 3, 4, 9, 9, 9, 3, 9, 1)


class LiveChain(Chain):
    """Do in one call of a kernel what the chain of a `Pipeline` does with a regular message.

    Regular is what the kernels for blocks take, of one frame, by the encoding of this machine.
    Anything else, `push` takes, as does each chain.
    """

    def __init__(self, pipeline: Pipeline, frames: FrameSettings) -> None:
        """Take a pipeline that `suits`."""
        super().__init__(pipeline.stages)
        assert pipeline.gravity is not None
        assert pipeline.integrator is not None
        self.kernel: Callable[[Array], int] | None = None
        """What does it; whoever has `kernels.live.take` compiled puts it here."""
        self.taken = 0
        """Messages that were taken by the kernel."""
        self._pipeline = pipeline
        self._gravity, self._integrator = pipeline.gravity, pipeline.integrator
        self._input = gravity_input(self._gravity.settings.attitude)
        encode = wire.odometry_encoder(frames.world, frames.body)
        self._written = encode(NavigationState(0, ZERO, ZERO))
        self._memory: Array | None = None
        self._waiting = 0

    def push(self, name: str, sample: Any) -> list[Output]:
        """Put one sample in under its name; return all outputs it caused, in order."""
        if self._memory is not None:
            self.settle()
            self._waiting = WAIT
        return super().push(name, sample)

    def take(self, name: str, data: bytes) -> list[Output] | None:
        """Put in a message as its bytes; None says that it is for `push`, and nothing changed."""
        if name != self._input or self.kernel is None:
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
        brought = self.kernel(memory)
        if brought == IRREGULAR:
            return None
        self.taken += 1
        outputs = self._walk(brought) if brought > RESTS else []
        outputs.append((ODOMETRY_MESSAGE, self._odometry.tobytes()))
        return outputs + self._pipeline.rest.of(bool(brought & RESTS))

    def settle(self) -> None:
        """Let the estimators hold their state: someone looks at it, or is going to change it."""
        memory, self._memory = self._memory, None
        if memory is None:
            return
        clock = layout.ticks(memory, layout.CLOCK)
        last_ns = int(clock[layout.LAST])
        self._gravity._timeline._last_ns = self._integrator._timeline._last_ns = last_ns
        parts = integrator.parts_of(self._integrator)
        assert parts is not None
        integrator.leave_motion(self._integrator, parts[0], layout.motion_of(memory))
        integrator.leave_growth(parts[1], layout.growth_of(memory))
        counting = self._pipeline.pedometer
        if counting is not None:
            line = slice(clock[layout.HEAD], clock[layout.TAIL])
            order = counting._order
            order._newest_ns = last_ns
            order._stamps = layout.ticks(memory, layout.LINE)[line].tolist()
            forces = layout.table(memory, layout.LINE + 1, 3)[line].tolist()
            order._samples = [(x, y, z) for x, y, z in forces]
            pedometer.leave_cells(counting, layout.cells_of(memory))

    def _walk(self, brought: int) -> list[Output]:
        """Take what a sample brought besides its Odometry."""
        counting, walking, says = (
            self._pipeline.pedometer,
            self._pipeline.step_odometry,
            self._pipeline.steps,
        )
        assert counting is not None
        assert walking is not None
        assert says is not None
        if brought & HEADS:
            stamp_ns = int(self._clock[layout.LAST])
            x, y, variance = (float(column[0]) for column in self._headings[1:])
            walking._orientation.append(Heading(stamp_ns, x, y, variance))
        states = []
        for k in range(brought // CELL):
            stamp_ns, magnitude = int(self._cells.stamp_ns[k]), float(self._cells.magnitude[k])
            states += counting.advance(stamp_ns, magnitude)
        return says.of(states) if states else []

    def _take_over(self, data: bytes) -> Array | None:
        """Take the state over from the estimators, for messages like this one, if that goes."""
        if self._waiting:
            self._waiting -= 1
            return None
        length = int.from_bytes(data[TEXT_AT - 4 : TEXT_AT], 'little')
        parts = self._parts()
        fits = len(data) == doubles_at(length) + 8 * layout.IMU_DOUBLES
        if parts is None or not fits:
            self._waiting = WAIT
            return None
        self._text_end = TEXT_AT + length
        self._text = data[TEXT_AT - 4 : self._text_end]
        self._memory = memory = layout.packed([_words(data), _words(self._written), *parts])
        self._imu, self._odometry = (
            memoryview(layout.part(memory, number)).cast('B')[4:]  # type: ignore[arg-type]
            for number in (layout.IMU, layout.ODOMETRY)
        )
        self._clock = layout.ticks(memory, layout.CLOCK)
        self._cells, self._headings = layout.cells_of(memory), layout.headings_of(memory)
        return memory

    def _parts(self) -> list[NDArray[Any]] | None:
        """Return what a memory holds besides messages; None where the stream is at work."""
        removal, integrating = self._gravity, self._integrator
        counting = self._pipeline.pedometer
        last_ns = gravity.regular_since(removal)
        if last_ns is None or last_ns != integrator.regular_since(integrating):
            return None
        if counting is not None and last_ns != pedometer.regular_since(counting):
            return None
        source, moving = removal._attitude, integrator.parts_of(integrating)
        assert moving is not None
        if isinstance(source, HeldAttitude):
            attitude, tilt = gravity.held(source), source.covariance
        else:
            assert isinstance(source, MessageAttitude)
            attitude, tilt = NO_ROTATION, source._fallback
        if attitude is None:
            return None
        clock = np.zeros(layout.TAIL + 1, np.int64)
        clock[layout.LAST] = last_ns
        clock[layout.LONGEST] = int(integrating.settings.max_gap * NANOSECONDS)
        waiting = self._in_line(clock)
        if waiting is None:
            return None
        return [
            clock,
            *map(np.array, (attitude, tilt)),
            np.array((removal.gravity, removal._gravity_variance)),
            np.array(removal._noise),
            *map(np.zeros, LEVELLED_WIDTHS),
            *map(np.zeros, STATE_WIDTHS),
            *layout.rules_in(integrator.rules_of(integrating)),
            *integrator.motion_of(integrating, moving[0]),
            *integrator.growth_of(moving[1]),
            *waiting,
        ]

    def _in_line(self, clock: NDArray[np.int64]) -> list[NDArray[Any]] | None:
        """Return what a memory holds of a pedometer, and write it into the clock."""
        counting, walking = self._pipeline.pedometer, self._pipeline.step_odometry
        if counting is None or walking is None:
            return [np.zeros(0)] * (layout.PARTS - layout.CELLS)
        order, resampler, history = counting._order, counting._resampler, walking._orientation
        longest = min(counting.settings.max_gap, LONGEST_STEP)
        clock[layout.LONGEST] = longest_ns = min(clock[layout.LONGEST], int(longest * NANOSECONDS))
        stamps = [resampler._last_ns, *order._stamps]
        too_long = any(after - before > longest_ns for before, after in pairwise(stamps))
        if too_long or history.newest_ns > clock[layout.LAST]:
            return None
        as_it_came = counting.settings.input == self._input
        clock[layout.COUNTED] = layout.AS_IT_CAME if as_it_came else layout.AS_LEVELLED
        clock[layout.HEADED] = HEADED.get(walking.settings.heading, layout.NOTHING)
        clock[layout.HEADING] = history.newest_ns
        clock[layout.HOLD], clock[layout.LIMIT] = order._hold_ns, order._limit
        clock[layout.TAIL] = waiting = len(order._stamps)
        line, forces = (
            np.zeros(2 * order._limit + 2, np.int64),
            np.zeros((2 * order._limit + 2, 3)),
        )
        line[:waiting], forces[:waiting] = order._stamps, np.reshape(order._samples, (waiting, 3))
        cells = pedometer.cells_of(counting, 4 + int(2.0 * LONGEST_STEP * resampler._rate))
        headings = HeadingColumns(np.zeros(1, np.int64), *np.zeros((3, 1)))
        return [*cells, line, forces, *headings, np.array([history._variance])]


def suits(pipeline: Pipeline, parts: Parts) -> bool:
    """Say whether there is a kernel for a pipeline and its settings."""
    frames = parts[FrameSettings]
    removal, moving, counting = pipeline.gravity, pipeline.integrator, pipeline.pedometer
    if removal is None or moving is None or integrator.parts_of(moving) is None:
        return False
    if not isinstance(removal._attitude, HeldAttitude | MessageAttitude):
        return False
    if frames.publish_tf or frames.mounting != 'parameters':
        return False
    mounting = mountings_of(frames)('')
    if mounting.rotation != IDENTITY_QUATERNION or mounting.translation != ZERO:
        return False
    stages = 2 if counting is None else 3
    if parts[PipelineSettings].source != 'topic' or len(pipeline.stages) != stages:
        return False
    return counting is None or counting.settings.input in (
        IMU,
        gravity_input(removal.settings.attitude),
    )


def _words(message: bytes) -> Array:
    """Return a message from four bytes before it on, which aligns its doubles."""
    return np.frombuffer(bytes(4) + message)
