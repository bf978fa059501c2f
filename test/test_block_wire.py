"""Many messages at once: the same bytes and samples as one by one."""

import math

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

from dead_reckoning import block_wire, wire
from dead_reckoning.core.blocks import AccelerationBlock, ImuBlock, StateBlock
from dead_reckoning.core.errors import WireError
from dead_reckoning.core.samples import (
    NOT_MEASURED,
    ImuSample,
    LinearAcceleration,
    NavigationState,
)

repeatable = settings(derandomize=True, database=None, deadline=None)
numbers = st.floats()
stamps = st.integers(-(2**31) * 10**9, 2**31 * 10**9 - 1)
ids = st.sampled_from(['', 'imu', 'imu_link', 'imu_lint', 'ü', 'a' * 40])


def tuples(count, elements=numbers):
    return st.tuples(*[elements] * count)


covariances = st.tuples(st.floats(0.0, 1e300), *[numbers] * 8)
quaternions = tuples(4).filter(lambda q: any(q))


def imus(frame_id):
    return st.builds(
        ImuSample,
        stamps,
        frame_id,
        tuples(3),
        tuples(9),
        st.none() | tuples(3),
        covariances,
        st.none() | quaternions,
        covariances,
    )


def same(first, second):
    """Say whether values are equal, NaN counting as itself and −0 not as 0."""
    return repr(first) == repr(second)


def decoded(messages):
    """Return what comes of each message: a sample, or the words of an error."""
    found = []
    for index, made in block_wire.decode_imus(messages):
        assert index == len(found)
        if isinstance(made, WireError):
            found.append(str(made))
        else:
            found.extend(map(made.sample, range(len(made))))
    return found


def one_by_one(messages):
    found = []
    for message in messages:
        try:
            found.append(wire.decode_imu(message))
        except WireError as error:
            found.append(str(error))
    return found


@repeatable
@given(st.lists(st.tuples(imus(ids), st.integers(1, 3)), max_size=8))
def test_messages_are_read_as_one_by_one(samples):
    messages = [wire.encode_imu(sample) for sample, count in samples for _ in range(count)]
    assert same(decoded(messages), one_by_one(messages))


@repeatable
@given(
    st.lists(
        st.tuples(imus(ids), st.integers(0, 40), st.integers(0, 255), st.binary(max_size=9)),
        max_size=8,
    )
)
def test_damaged_messages_are_read_or_refused_as_one_by_one(damaged):
    messages = []
    for sample, at, byte, rest in damaged:
        message = wire.encode_imu(sample)
        messages += [message, message[:at] + bytes([byte]) + message[at + 1 :] + rest, message]
    assert same(decoded(messages), one_by_one(messages))


def test_a_message_cut_short_is_refused_at_every_byte():
    whole = wire.encode_imu(ImuSample(5, 'imu_link', (1.0, 2.0, 3.0)))
    for length in range(len(whole)):
        first, error, last = block_wire.decode_imus([whole, whole[:length], whole])
        assert (first[0], error[0], last[0]) == (0, 1, 2)
        assert isinstance(error[1], WireError)


def test_one_frame_is_one_block_whatever_the_padding():
    generator = np.random.default_rng(1)
    messages = []
    for number in range(50):
        message = bytearray(wire.encode_imu(ImuSample(number, 'imu', (1.0, 2.0, 3.0))))
        message[20:24] = generator.bytes(4)  # after 'imu' and its zero
        messages.append(bytes(message))
    ((_, block),) = block_wire.decode_imus(messages)
    assert len(block) == 50
    assert block.stamp_ns.tolist() == list(range(50))


def test_a_new_frame_is_a_new_block():
    frames = ['a', 'a', 'b', 'long', 'long', 'a']
    messages = [wire.encode_imu(ImuSample(5, frame, (1.0, 2.0, 3.0))) for frame in frames]
    blocks = [(index, block.frame_id) for index, block in block_wire.decode_imus(messages)]
    assert blocks == [(0, 'a'), (2, 'b'), (3, 'long'), (5, 'a')]


def test_columns_are_arrays_of_their_own():
    messages = [wire.encode_imu(ImuSample(5, 'imu', (1.0, 2.0, 3.0)))] * 3
    ((_, block),) = block_wire.decode_imus(messages)
    assert block.specific_force.flags.c_contiguous
    assert block.specific_force.flags.aligned


@repeatable
@given(ids.flatmap(lambda name: st.lists(imus(st.just(name)), min_size=1, max_size=8)))
@example([ImuSample(-1, '', (math.nan,) * 3)])
def test_imus_are_written_as_one_by_one(samples):
    messages = block_wire.encode_imus(ImuBlock.of(samples))
    assert messages == [wire.encode_imu(sample) for sample in samples]


@repeatable
@given(
    ids.flatmap(
        lambda name: st.lists(
            st.builds(LinearAcceleration, stamps, st.just(name), tuples(3), tuples(9)),
            min_size=1,
            max_size=8,
        )
    )
)
def test_accelerations_are_written_as_one_by_one(samples):
    messages = block_wire.encode_accelerations(AccelerationBlock.of(samples))
    assert messages == [wire.encode_acceleration(sample) for sample in samples]


isotropic = st.floats(0.0, 1e3).map(lambda v: (v, 0.0, 0.0, 0.0, v, 0.0, 0.0, 0.0, v))
states = st.builds(
    NavigationState,
    stamps,
    tuples(3),
    tuples(3, st.floats(-1e3, 1e3)),
    tuples(4, st.floats(-1.0, 1.0)),
    tuples(9),
    tuples(9, st.floats(-1e3, 1e3)) | isotropic,
    tuples(9),
    st.none() | tuples(3),
    covariances,
    st.booleans(),
)


@repeatable
@given(st.lists(states, min_size=1, max_size=8), ids, ids)
def test_odometries_are_written_as_one_by_one(samples, frame_id, child_frame_id):
    messages = block_wire.odometries_encoder(frame_id, child_frame_id)(StateBlock.of(samples))
    encode = wire.odometry_encoder(frame_id, child_frame_id)
    assert messages == [encode(sample) for sample in samples]


def test_what_was_written_is_read_back():
    generator = np.random.default_rng(2)
    samples = [
        ImuSample(
            k + 1,
            'imu',
            tuple(generator.normal(size=3).tolist()),
            orientation_covariance=NOT_MEASURED,
        )
        for k in range(100)
    ]
    ((_, block),) = block_wire.decode_imus(block_wire.encode_imus(ImuBlock.of(samples)))
    assert block.specific_force.tolist() == [list(s.specific_force) for s in samples]


def test_no_messages_are_no_blocks():
    assert list(block_wire.decode_imus([])) == []
