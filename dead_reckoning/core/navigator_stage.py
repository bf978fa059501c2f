"""What the inertial navigator takes and gives in a chain, by topic name."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from dead_reckoning.core import kernels
from dead_reckoning.core.aiding import Aiding
from dead_reckoning.core.blocks import Stamped, StateBlock
from dead_reckoning.core.chain import END, FAULT, NOTICE, Chain, Output, Stage
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.errors import NotLevelledError, RestartError, SampleError
from dead_reckoning.core.kernels.navigation.filter import navigate
from dead_reckoning.core.kernels.navigation.smoother import smooth
from dead_reckoning.core.mounting import IDENTITY_MOUNTING, Mounting, Mountings, carried, unmounted
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.navigator import InertialNavigator
from dead_reckoning.core.parameters import Settings
from dead_reckoning.core.path import PathKeeper
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import matrix_from_quaternion, rotate
from dead_reckoning.core.samples import NANOSECONDS, ZERO, ImuSample, NavigationState, Vector
from dead_reckoning.core.smoother import StrideSmoother
from dead_reckoning.core.stages import (
    AIDING_ODOMETRY,
    AIDING_POSE,
    AIDING_TWIST,
    COMPASS,
    ODOMETRY,
    PATH,
    SET_POSE,
    SMOOTHED,
    STATISTIC,
    THRESHOLD,
    RestOutput,
)


class BodyStates:
    """Carry the states of a navigator to the body on which its sensor sits.

    ``starts`` has, for each start of the navigator that gave a state, where the sensor was then
    from the body, shape (3,) [m], world frame: both begin at the origin.
    """

    def __init__(self, navigator: InertialNavigator, mountings: Mountings) -> None:
        self.mounting: Mounting = IDENTITY_MOUNTING
        """That of the sensor whose samples come."""
        self.starts: list[Vector] = []
        self._navigator = navigator
        self._mountings = mountings
        self._begun: object = None
        self._last_ns = 0
        self._ends: list[int] = []  # of the start before, where the stamps went on from there

    @property
    def start(self) -> Vector:
        """Where the sensor was at this start; raises `NotLevelledError` before its first state."""
        if self.mounting.translation == ZERO:
            return ZERO
        if self._navigator.strides is not self._begun:
            raise NotLevelledError('a pose came before the first state: it is known then where to')
        return self.starts[-1]

    def turned(self, imu: ImuSample) -> ImuSample:
        """Return a sample in the axes of the body; raises `MissingMountingError`."""
        mounting = self._mountings(imu.frame_id)
        if mounting is not self.mounting:
            self.mounting = mounting
            self._navigator.mount(mounting.rotation)
        return mounting.to_body(imu)

    def of(self, state: NavigationState) -> NavigationState:
        """Return the state of the body, of the next state that the navigator gave."""
        if self._navigator.strides is not self._begun:  # it counts anew from each start
            self._begun = self._navigator.strides
            self._ends.append(self._last_ns if self._last_ns < state.stamp_ns else 0)
            self.starts.append(
                rotate(matrix_from_quaternion(state.attitude), self.mounting.translation)
            )
        self._last_ns = state.stamp_ns
        return self.moved(state, self.starts[-1])

    def of_smoothed(self, block: StateBlock) -> Iterator[NavigationState]:
        """Yield the states of the body for smoothed ones of the last start."""
        start_w = self.starts[-1] if self.starts else ZERO
        for k in range(len(block)):
            yield self.moved(block.sample(k), start_w)

    def smoothed(self, blocks: Iterable[StateBlock]) -> Iterator[StateBlock]:
        """Yield the states of the body for those of a smoother, from the last to the first."""
        at, later_ns = len(self.starts) - 1, None
        for block in blocks:
            last_ns = block.stamp_ns[-1]
            if later_ns is not None and at >= 0 and not self._ends[at] < last_ns < later_ns:
                at -= 1  # the stamps went back between the two, or it diverged
            later_ns = block.stamp_ns[0]
            if self.mounting.translation == ZERO or at < 0:
                yield block
            else:
                states = (block.sample(k) for k in range(len(block)))
                yield StateBlock.of([self.moved(state, self.starts[at]) for state in states])

    def moved(self, state: NavigationState, start_w: Vector) -> NavigationState:
        """Return the state of the body where the lever arm was ``start_w`` at the start."""
        lever_arm = self.mounting.translation
        if lever_arm == ZERO:
            return state
        rot_wb = matrix_from_quaternion(state.attitude)
        return carried(state, rot_wb, lever_arm, start_w, state.angular_velocity_covariance)


class StrideOutputs:
    """Say where the body was, one stride late, where `navigator.smoothing` asks for it."""

    def __init__(self, navigator: InertialNavigator, body: BodyStates) -> None:
        self._navigator = navigator
        self._body = body
        self._smoother = StrideSmoother(navigator) if navigator.settings.smoothing else None
        self._path = PathKeeper()
        self._begun: object = None

    def of(self, states: Sequence[NavigationState]) -> list[Output]:
        """Return what comes of the next states that the navigator gave, or of none.

        At a new start that is what was left of the way before.
        """
        if self._smoother is None:
            return []
        outputs: list[Output] = []
        if self._navigator.strides is not self._begun:  # it counts anew from each start
            outputs = self.end()
            self._begun, self._path = self._navigator.strides, PathKeeper()
        if states:
            outputs += self._outputs(self._smoother.take(StateBlock.of(states)))
        return outputs

    def of_block(self, states: StateBlock) -> list[Output]:
        """Return what comes of a block of them."""
        if self._smoother is None:
            return []
        outputs = self._outputs(self._smoother.take(states))
        return [(n, Stamped(v.stamp_ns, v)) if n == PATH else (n, v) for n, v in outputs]

    def end(self) -> list[Output]:
        """Return what is left at the end."""
        return [] if self._smoother is None else self._outputs(self._smoother.flush())

    def _outputs(self, blocks: Iterable[StateBlock]) -> list[Output]:
        outputs: list[Output] = []
        for block in blocks:
            for state in self._body.of_smoothed(block):
                outputs.append((SMOOTHED, state))
                self._path.take(state)
            path = self._path.path()
            if path is not None:
                outputs.append((PATH, path))
        return outputs


def kept(settings: NavigatorSettings) -> bool:
    """Say whether an earlier run has kept what takes long to compile."""
    row, rows = np.zeros(1), np.zeros((1, 1))
    filters = kernels.load(navigate, rows, rows, rows, row, row, rows, rows, rows)
    if filters and settings.smoothing:
        return kernels.load(smooth, rows, rows, row, rows, rows, rows)
    return filters


def load_kernels(settings: NavigatorSettings, common: CommonSettings, *own: Settings) -> None:
    """Let a navigator of these settings align, and end, so that samples need not wait for it.

    That takes a second, where the kernels have to be compiled ten or more.
    """
    settings = replace(settings, rest_duration=0.5, max_gap=0.5)
    chain = Chain([navigator_stage(InertialNavigator(settings, common, *own))])
    for k in range(60):
        chain.push(
            settings.input,
            ImuSample(
                (1 + k) * NANOSECONDS // 100, '', (0.0, 0.0, GRAVITY), angular_velocity=ZERO
            ),
        )
    chain.end()


def navigator_stage(
    navigator: InertialNavigator,
    mountings: Mountings = unmounted,
    body: BodyStates | None = None,
    rest: RestOutput | None = None,
    frames: FrameSettings | None = None,
    strides: StrideOutputs | None = None,
) -> Stage:
    """Take an Imu with a rate of turn, a compass, and what else measures velocity and pose.

    Give the state of the body, rest on change, and where asked for what smoothing makes of it.
    States are late by the look-ahead of the detector, and have the stamps of their samples; `END`
    brings the last of them.  What the detector goes by comes with them.
    """
    body = body or BodyStates(navigator, mountings)
    strides = strides or StrideOutputs(navigator, body)
    rests = rest or RestOutput()
    aiding = Aiding(
        navigator,
        frames,
        mountings,
        lambda: body.mounting.translation,
        lambda: body.start,
    )

    def give(states: Sequence[NavigationState]) -> list[Output]:
        outputs: list[Output] = []
        for state in states:
            outputs.append((ODOMETRY, body.of(state)))
            outputs.extend(rests.of(state.stationary))
        if outputs:
            outputs += [(STATISTIC, navigator.statistic), (THRESHOLD, navigator.threshold)]
        return outputs + strides.of(states)

    def take(imu: ImuSample) -> list[Output]:
        turned = body.turned(imu)
        restarts, aligned = navigator.restarts, navigator.aligned
        outputs = strides.of(())
        try:
            if navigator.begins_anew(turned):
                outputs += give(navigator.flush())
            outputs += give(navigator.update(turned))
        except SampleError as error:
            outputs.append((FAULT, error))
        if navigator.restarts != restarts:
            outputs.append((FAULT, RestartError('the stamps went back: looking for rest anew')))
        if navigator.aligned and navigator.aligned is not aligned:
            outputs.append((NOTICE, f'aligned: {navigator.aligned}'))
        outputs.extend((FAULT, finding) for finding in navigator.findings)
        navigator.findings.clear()
        return outputs

    def aided(name: str, take: Callable[[Any], None]) -> Callable[[Any], tuple[()]]:
        def given(sample: Any) -> tuple[()]:
            try:
                take(sample)
            except SampleError as error:
                navigator.dropped[name] += 1
                raise type(error)(f'{name}: {error}') from error
            return ()

        return given

    return {
        navigator.settings.input: take,
        COMPASS: _silent(navigator.follow_compass),
        AIDING_TWIST: aided(AIDING_TWIST, aiding.take_twist),
        AIDING_ODOMETRY: aided(AIDING_ODOMETRY, aiding.take_odometry),
        AIDING_POSE: aided(AIDING_POSE, aiding.take_pose),
        SET_POSE: aided(SET_POSE, aiding.set_pose),
        END: lambda _: [*give(navigator.flush()), *strides.end()],
    }


def _silent(take: Callable[[Any], None]) -> Callable[[Any], tuple[()]]:
    """Return what takes a sample and gives nothing."""

    def given(sample: Any) -> tuple[()]:
        take(sample)
        return ()

    return given
