"""Run a chain on messages as they come: compiled where they are regular, else like any chain."""

from __future__ import annotations

from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.mounting import mountings_of
from dead_reckoning.core.parameters import Parts
from dead_reckoning.core.pipeline import Pipeline, PipelineSettings
from dead_reckoning.core.samples import IDENTITY_QUATERNION, ZERO
from dead_reckoning.live.chain import LiveChain
from dead_reckoning.live.integrator import IntegratorChain
from dead_reckoning.live.navigator import NavigatorChain

KINDS: tuple[type[LiveChain], ...] = (IntegratorChain, NavigatorChain)


def live_chain(pipeline: Pipeline, parts: Parts) -> LiveChain | None:
    """Return the chain that takes messages for a pipeline of these settings, if there is one."""
    frames = parts[FrameSettings]
    if frames.publish_tf or frames.mounting != 'parameters':
        return None
    mounting = mountings_of(frames)('')
    if mounting.rotation != IDENTITY_QUATERNION or mounting.translation != ZERO:
        return None
    if parts[PipelineSettings].source != 'topic':
        return None
    for kind in KINDS:
        taken = kind.taken_of(pipeline)
        if taken is not None:
            return kind(pipeline, frames, taken)
    return None
