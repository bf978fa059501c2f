"""Run stages over blocks of samples: the same outputs, in columns."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import groupby, pairwise
from typing import Any

import numpy as np

from dead_reckoning.core.batch import NOTHING, Run
from dead_reckoning.core.batch.gravity import level_run
from dead_reckoning.core.batch.integrator import integrator_run
from dead_reckoning.core.batch.navigator import navigator_run
from dead_reckoning.core.batch.pedometer import pedometer_run
from dead_reckoning.core.blocks import ANY_BLOCK, BLOCKS, ImuBlock, Stamped, StateBlock
from dead_reckoning.core.chain import END, FAULT, Chain, Output, Stage
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.errors import DeadReckoningError
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.kernels import accelerated
from dead_reckoning.core.mounting import Mountings, unmounted
from dead_reckoning.core.navigator import InertialNavigator
from dead_reckoning.core.navigator_stage import BodyStates, StrideOutputs, navigator_stage
from dead_reckoning.core.path import Path
from dead_reckoning.core.pedometer import Pedometer
from dead_reckoning.core.samples import NavigationState
from dead_reckoning.core.stages import (
    LEVELLED,
    ODOMETRY,
    STATIONARY,
    STATISTIC,
    THRESHOLD,
    RestOutput,
    StepOutputs,
    gravity_input,
    gravity_stage,
    integrator_stage,
    pedometer_stage,
)
from dead_reckoning.core.step_odometry import StepOdometry

PART = 64
"""Samples of a part: less than the headings of ten seconds that are kept, at 12.5 Hz too."""


def blockwise(stage: Stage, runs: Mapping[str, Run] | None = None) -> Stage:
    """Return a stage that takes and gives blocks, and runs another one sample by sample.

    Outputs of one name come as one block where they are samples, and as `Stamped` values where
    they are not, as faults and notices; each name's are in order.  ``runs``, by name of the input,
    do many samples at once where they can.
    """
    runs = runs or {}
    return {name: partial(_take, take, runs.get(name)) for name, take in stage.items()}


def gravity_block_stage(removal: GravityRemoval, mountings: Mountings = unmounted) -> Stage:
    """Give what `gravity_stage` gives, in blocks."""
    run = level_run(removal, mountings)
    return blockwise(
        gravity_stage(removal, mountings), {gravity_input(removal.settings.attitude): run}
    )


def integrator_block_stage(
    integrator: Integrator, mountings: Mountings = unmounted, rest: RestOutput | None = None
) -> Stage:
    """Give what `integrator_stage` gives, in blocks."""
    run = integrator_run(integrator, mountings)
    stage = blockwise(integrator_stage(integrator, mountings), {LEVELLED: run})
    return _with_rests(stage, rest or RestOutput())


def navigator_block_stage(
    navigator: InertialNavigator,
    mountings: Mountings = unmounted,
    body: BodyStates | None = None,
    rest: RestOutput | None = None,
    frames: FrameSettings | None = None,
    strides: StrideOutputs | None = None,
) -> Stage:
    """Give what `navigator_stage` gives, in blocks, without what the detector goes by."""
    body = body or BodyStates(navigator, mountings)
    strides = strides or StrideOutputs(navigator, body)
    stage = navigator_stage(navigator, mountings, body, rest, frames, strides)
    run = navigator_run(navigator, mountings, strides)

    def end(_: None) -> list[Output]:
        made: dict[str, list[NavigationState]] = {}
        outputs: list[Output] = []
        for name, value in stage[END](None):
            if isinstance(value, NavigationState):
                made.setdefault(name, []).append(value)
            elif isinstance(value, Path):
                outputs.append((name, Stamped(value.stamp_ns, value)))
        return [*((name, StateBlock.of(states)) for name, states in made.items()), *outputs]

    stages: Stage = {**blockwise(stage, {navigator.settings.input: run}), END: end}
    return _with_rests(stages, rest or RestOutput())


def pedometer_block_stage(
    pedometer: Pedometer,
    odometry: StepOdometry,
    mountings: Mountings = unmounted,
    steps: StepOutputs | None = None,
) -> Stage:
    """Give what `pedometer_stage` gives, in blocks."""
    says = steps or StepOutputs(pedometer, odometry)
    run = pedometer_run(pedometer, odometry, says, mountings)
    stage = pedometer_stage(pedometer, odometry, mountings, says)

    def end(_: None) -> list[Output]:
        newest_ns = pedometer.newest_ns
        if newest_ns is None:
            return []
        return [
            (n, StateBlock.of([v]) if isinstance(v, NavigationState) else Stamped(newest_ns, v))
            for n, v in stage[END](None)
        ]

    taken: Stage = {**blockwise(stage, {pedometer.settings.input: run}), END: end}
    if pedometer.settings.heading != 'navigator':
        return taken
    return {**taken, **_one_late(pedometer.settings.input, taken)}


def in_parts(stages: Iterable[Stage], inputs: Iterable[str]) -> Stage:
    """Run stages over short parts of blocks, for those that go by what another one knows.

    ``inputs`` are all that comes from outside.  The stamps of a part rise.
    """
    chain = Chain(stages)

    def take(name: str, block: Any) -> list[Output]:
        made: dict[str, list[Any]] = {}
        outputs: list[Output] = []
        for part in _parts(block):
            for given, value in chain.push(name, part):
                if isinstance(value, ANY_BLOCK):
                    made.setdefault(given, []).append(value)
                else:
                    outputs.append((given, value))
        return [*outputs, *((given, _joined(values)) for given, values in made.items())]

    return {**{name: partial(take, name) for name in inputs}, END: lambda _: chain.end()}


def _parts(block: Any) -> Iterable[Any]:
    if not isinstance(block, ImuBlock):
        return [block]
    back = np.flatnonzero(np.diff(block.stamp_ns) < 0) + 1
    cuts = sorted({*range(0, len(block), PART), *back.tolist(), len(block)})
    return (block.part(begin, end) for begin, end in pairwise(cuts))


def _one_late(name: str, stage: Stage) -> Stage:
    """Let a stage take a block of an input when the next one comes, or the end."""
    waiting: list[Any] = []

    def take() -> Iterable[Output]:
        return stage[name](waiting.pop(0)) if waiting else ()

    def later(block: Any) -> Iterable[Output]:
        outputs = list(take())
        waiting.append(block)
        return outputs

    return {name: later, END: lambda _: [*take(), *stage[END](None)]}


def _with_rests(stage: Stage, rest: RestOutput) -> Stage:
    """Say when rest changed by the states of a stage, whichever way they came."""

    def give(take: Callable[[Any], Iterable[Output]], value: Any) -> list[Output]:
        outputs = [(n, v) for n, v in take(value) if n not in (STATIONARY, STATISTIC, THRESHOLD)]
        for states in [v for n, v in outputs if n == ODOMETRY]:
            outputs.extend(_changes(states, rest))
        return outputs

    return {name: partial(give, take) for name, take in stage.items()}


def _changes(states: StateBlock, rest: RestOutput) -> list[Output]:
    rests = states.stationary
    changed = [0, *(np.flatnonzero(rests[1:] != rests[:-1]) + 1).tolist()]
    return [
        (name, Stamped(int(states.stamp_ns[at]), value))
        for at in changed
        for name, value in rest.of(bool(rests[at]))
    ]


def _take(take: Callable[[Any], Iterable[Output]], run: Run | None, block: Any) -> list[Output]:
    made: dict[str, list[Any]] = {}
    outputs: list[Output] = []

    def collect(given: Iterable[Output], stamp_ns: int) -> None:
        for name, value in given:
            if type(value) in BLOCKS or isinstance(value, ANY_BLOCK):
                made.setdefault(name, []).append(value)
            elif isinstance(value, Stamped):
                outputs.append((name, value))
            else:
                outputs.append((name, Stamped(stamp_ns, value)))

    fast = run if run is not None and accelerated() else None
    index = 0
    while index < len(block):
        count, given = NOTHING if fast is None else fast(block, index)
        collect(given, 0)
        index += count
        if index < len(block):
            stamp_ns = int(block.stamp_ns[index])
            try:
                collect(take(block.sample(index)), stamp_ns)
            except DeadReckoningError as error:
                collect([(FAULT, error)], stamp_ns)
            index += 1
    outputs.extend((name, _joined(values)) for name, values in made.items())
    return outputs


def _joined(values: Sequence[Any]) -> Any:
    """Return samples and blocks of them as one block."""
    blocks: list[Any] = []
    for kind, group in groupby(values, type):
        together = list(group)
        blocks += [BLOCKS[kind].of(together)] if kind in BLOCKS else together
    return blocks[0].join(blocks)
