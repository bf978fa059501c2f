"""Chains that get messages as nodes give them."""

import dataclasses

import numpy as np
import pytest

from dead_reckoning import wire
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.chain import FAULT
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.errors import WireError
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.stages import (
    ACCELERATION,
    IMU,
    LEVELLED,
    ODOMETRY,
    ODOMETRY_MESSAGE,
    STATISTIC,
    STEP_ODOMETRY,
    THRESHOLD,
    TOTALS,
)
from dead_reckoning.live import live_chain

DOUBLES = 8 * 85
BETWEEN = (IMU, ACCELERATION, LEVELLED, STATISTIC, THRESHOLD)
"""Outputs that are there for the stream only."""


class Driven:
    """A chain that gets messages as a node gives them, and what comes out of it, in order."""

    def __init__(self, values, ready):
        self.configuration = Configuration(values)
        self.pipeline = Pipeline(self.configuration)
        self.chain = live_chain(self.pipeline, self.configuration)
        self.chain.ready = ready
        frames = self.configuration[FrameSettings]
        self.encode = wire.odometry_encoder(frames.world, frames.body)
        self.outputs = []

    def message(self, name, data):
        flow = self.chain.take(name, data)
        if flow is None:
            try:
                flow = self.chain.push(name, wire.decode_imu(data))
            except WireError as error:
                flow = [(FAULT, error)]
        self.collect(flow)

    def push(self, name, sample):
        self.collect(self.chain.push(name, sample))

    def service(self, call, *arguments):
        """Do what a node does: services and changed settings find the chain settled."""
        self.chain.settle()
        made = call(self, *arguments)
        if made is TOTALS:
            self.collect(self.chain.push(TOTALS, ()))

    def collect(self, flow):
        for name, value in flow:
            if name in BETWEEN:
                continue
            if name in (ODOMETRY, STEP_ODOMETRY):
                value = self.encode(value)
            self.outputs.append((ODOMETRY if name == ODOMETRY_MESSAGE else name, value))


def spoiled(random, data):
    """Return a message with one of the faults that messages have."""
    return random.choice(
        [
            data[:40],
            data[:12] + b'\xff\xff\xff\x7f' + data[16:],
            data[:8] + b'\xff\xff\xff\xff' + data[12:],
            b'\x00\x00' + data[2:],  # big-endian, as it says
            data + bytes(8),
            data[:-8],
            b'',
        ]
    )


def driven(values, happens, ready=True):
    """Return a chain after all that happens: calls of `Driven`, in order."""
    made = Driven({key: value for key, value in values.items() if key != 'heard'}, ready)
    for call, *arguments in happens:
        getattr(made, call)(*arguments)
    return made


def assert_same(found, expected):
    assert [name for name, _ in found] == [name for name, _ in expected]
    for (name, ours), (_, theirs) in zip(found, expected, strict=True):
        if name in (ODOMETRY, STEP_ODOMETRY):
            assert ours[:-DOUBLES] == theirs[:-DOUBLES]
            ours, theirs = (np.frombuffer(data[-DOUBLES:]) for data in (ours, theirs))
            np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9, err_msg=name)
        elif dataclasses.is_dataclass(theirs):
            assert dataclasses.astuple(ours) == pytest.approx(dataclasses.astuple(theirs))
        elif isinstance(theirs, float):
            assert ours == pytest.approx(theirs), name
        else:
            assert repr(ours) == repr(theirs)
