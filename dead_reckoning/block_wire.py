"""Read and write many messages at once: blocks in and out, in the layouts of `wire`.

Messages of one frame id are as long as each other, so a run of them is an array whose rows are
messages: one copy per field, and no object per message.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import groupby, pairwise
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from dead_reckoning import wire
from dead_reckoning.core.blocks import AccelerationBlock, Array, ImuBlock, Stamps, StateBlock
from dead_reckoning.core.errors import WireError
from dead_reckoning.core.rotation import (
    matrix_from_quaternion,
    product,
    rotate_back,
    similarity,
    transposed,
)
from dead_reckoning.core.samples import (
    IDENTITY_QUATERNION,
    NANOSECONDS,
    NOT_MEASURED,
    UNMEASURED_VARIANCE,
)

HEAD = np.dtype([('encoding', '<u2'), ('options', '<u2'), ('sec', '<i4'), ('nanosec', '<u4')])
LENGTH = np.dtype('<u4')
TEXT_AT = HEAD.itemsize + LENGTH.itemsize

IMU = np.dtype(
    [
        ('orientation', '<f8', 4),
        ('orientation_covariance', '<f8', 9),
        ('angular_velocity', '<f8', 3),
        ('angular_velocity_covariance', '<f8', 9),
        ('specific_force', '<f8', 3),
        ('specific_force_covariance', '<f8', 9),
    ]
)
ACCELERATION = np.dtype([('linear', '<f8', 3), ('angular', '<f8', 3), ('covariance', '<f8', 36)])
ODOMETRY = np.dtype(
    [
        ('position', '<f8', 3),
        ('attitude', '<f8', 4),
        ('pose_covariance', '<f8', 36),
        ('linear', '<f8', 3),
        ('angular', '<f8', 3),
        ('twist_covariance', '<f8', 36),
    ]
)

FIRST = [0, 1, 2, 6, 7, 8, 12, 13, 14]
"""Where the first block on the diagonal of a (6, 6) matrix is."""
SECOND = [21, 22, 23, 27, 28, 29, 33, 34, 35]
CROSS = [3, 4, 5, 9, 10, 11, 15, 16, 17]
CROSS_BACK = [18, 24, 30, 19, 25, 31, 20, 26, 32]
"""Where that of both is, and its transpose."""

Anywhere = TypeVar('Anywhere', int, Stamps)


def decode_imus(messages: Sequence[bytes]) -> Iterator[tuple[int, ImuBlock | WireError]]:
    """Read sensor_msgs/Imu: a block of each run of messages with one frame id, in order.

    Each comes with the index of its first message.  A message that is none is the error that
    `wire.decode_imu` raises.
    """
    index = 0
    for length, group in groupby(messages, len):
        run = list(group)
        joined = b''.join(run)
        for begin, end in _runs(joined, length) if length >= TEXT_AT else [(0, len(run))]:
            made = _imus(joined[begin * length : end * length], length)
            if made is not None:
                yield index + begin, made
            else:
                yield from _one_by_one(run[begin:end], index + begin)
        index += len(run)


def _runs(joined: bytes, length: int) -> list[tuple[int, int]]:
    """Cut messages of one length where the frame id changes, and around those that are none."""
    rows = np.frombuffer(joined, np.uint8).reshape(-1, length)
    text = rows[:, HEAD.itemsize : TEXT_AT].copy().view(LENGTH)[:, 0].astype(np.int64)
    nanosec = rows[:, 8:12].copy().view('<u4')[:, 0]
    fits = (doubles_at(text) + IMU.itemsize <= length) & (nanosec < NANOSECONDS)
    fits &= (rows[:, 0] == wire.LITTLE_ENDIAN[0]) & (rows[:, 1] == wire.LITTLE_ENDIAN[1])
    # After the text is padding, which may be anything.
    longest = int(text[fits].max(initial=0))
    names = np.where(np.arange(longest) < text[:, None], rows[:, TEXT_AT : TEXT_AT + longest], 0)
    key = np.column_stack([fits, text, names])
    cuts = np.flatnonzero((key[1:] != key[:-1]).any(axis=1)) + 1
    return list(pairwise([0, *cuts.tolist(), len(rows)]))


def doubles_at(text: Anywhere) -> Anywhere:
    """Return where the doubles begin after a frame id of some bytes, its zero included."""
    at = TEXT_AT - 4 + text  # counted from after the encapsulation
    return 4 + at + -at % 8


def _one_by_one(
    messages: Sequence[bytes], index: int
) -> Iterator[tuple[int, ImuBlock | WireError]]:
    for number, message in enumerate(messages, index):
        try:
            yield number, ImuBlock.of([wire.decode_imu(message)])
        except WireError as error:
            yield number, error


def _imus(joined: bytes, length: int) -> ImuBlock | None:
    """Return messages of one layout as a block, or None where the first is none."""
    try:
        frame_id = wire.decode_imu(joined[:length]).frame_id
    except WireError:
        return None
    text = int.from_bytes(joined[HEAD.itemsize : TEXT_AT], 'little')
    rows: NDArray[Any] = np.frombuffer(
        joined,
        np.dtype(
            {
                'names': ['head', 'imu'],
                'formats': [HEAD, IMU],
                'offsets': [0, doubles_at(text)],
                'itemsize': length,
            }
        ),
    )
    columns = {name: rows['imu'][name].copy() for name in IMU.names or ()}
    for name in ('orientation', 'angular_velocity'):
        covariance = columns[f'{name}_covariance']
        missing = ~(covariance[:, 0] >= 0.0)  # NaN too
        if name == 'orientation':
            missing |= ~columns[name].any(axis=1)
        columns[name][missing], covariance[missing] = 0.0, NOT_MEASURED
    stamps = rows['head']['sec'].astype(np.int64) * NANOSECONDS + rows['head']['nanosec']
    return ImuBlock(stamps, frame_id, **columns)


def encode_imus(block: ImuBlock) -> list[bytes]:
    """Write sensor_msgs/Imu, a message for each sample."""
    rows, imu = _rows(block.stamp_ns, IMU, block.frame_id)
    for name in IMU.names or ():
        imu[name] = getattr(block, name)
    for name, nothing in (('orientation', IDENTITY_QUATERNION), ('angular_velocity', 0.0)):
        missing = getattr(block, f'{name}_covariance')[:, 0] < 0.0
        imu[name][missing], imu[f'{name}_covariance'][missing] = nothing, NOT_MEASURED
    return _messages(rows)


def encode_accelerations(block: AccelerationBlock) -> list[bytes]:
    """Write geometry_msgs/AccelWithCovarianceStamped; the angular part is not measured."""
    rows, accelerations = _rows(block.stamp_ns, ACCELERATION, block.frame_id)
    accelerations['linear'] = block.acceleration
    accelerations['covariance'][:, FIRST] = block.covariance
    accelerations['covariance'][:, SECOND] = NOT_MEASURED
    return _messages(rows)


def odometries_encoder(frame_id: str, child_frame_id: str) -> Callable[[StateBlock], list[bytes]]:
    """Return a function that writes states as nav_msgs/Odometry between these two frames."""
    huge = UNMEASURED_VARIANCE

    def encode(block: StateBlock) -> list[bytes]:
        rows, states = _rows(block.stamp_ns, ODOMETRY, frame_id, child_frame_id)
        # The functions of core are sums and products: they take columns as they take numbers.
        attitude: Any = tuple(block.attitude.T)
        velocity: Any = tuple(block.velocity.T)
        covariance: Any = tuple(block.velocity_covariance.T)
        rot_wb = matrix_from_quaternion(attitude)
        rot_bw = transposed(rot_wb)
        states['position'], states['attitude'] = block.position, block.attitude
        states['pose_covariance'][:, FIRST] = block.position_covariance
        states['pose_covariance'][:, SECOND] = block.attitude_covariance
        states['linear'] = np.column_stack(rotate_back(rot_wb, velocity))
        turned = similarity(rot_bw, covariance)
        states['twist_covariance'][:, FIRST] = np.where(
            _is_sphere(block.velocity_covariance)[:, None],
            block.velocity_covariance,
            np.column_stack(turned),
        )
        if block.pose_cross_covariance is not None:
            for place in (CROSS, CROSS_BACK):
                states['pose_covariance'][:, place] = block.pose_cross_covariance
        if block.twist_cross_covariance is not None:
            cross: Any = tuple(block.twist_cross_covariance.T)
            for place in (CROSS, CROSS_BACK):
                states['twist_covariance'][:, place] = np.column_stack(product(rot_bw, cross))
        missing = block.angular_velocity_covariance[:, 0] < 0.0
        states['angular'] = np.where(missing[:, None], 0.0, block.angular_velocity)
        states['twist_covariance'][:, SECOND] = np.where(
            missing[:, None],
            (huge, 0.0, 0.0, 0.0, huge, 0.0, 0.0, 0.0, huge),
            block.angular_velocity_covariance,
        )
        return _messages(rows)

    return encode


def _is_sphere(covariance: Array) -> NDArray[np.bool_]:
    """Say which covariances `rotate_covariance` leaves as they are."""
    xx, xy, xz, _, yy, yz, _, _, zz = covariance.T
    sphere: NDArray[np.bool_] = (xx == yy) & (yy == zz) & (xy == 0.0) & (xz == 0.0) & (yz == 0.0)
    return sphere


def _rows(
    stamps: Stamps, doubles: np.dtype[Any], *texts: str
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return messages with head and texts written, and their doubles as a view, all zero."""
    _, middle = wire.layout(doubles.itemsize // 8, *texts)
    rows = np.zeros(
        len(stamps),
        np.dtype([('head', HEAD), ('texts', f'S{len(middle)}'), ('doubles', doubles)]),
    )
    rows['head']['encoding'] = int.from_bytes(wire.LITTLE_ENDIAN[:2], 'little')
    rows['head']['sec'], rows['head']['nanosec'] = np.divmod(stamps, NANOSECONDS)
    rows['texts'] = middle
    return rows, rows['doubles']


def _messages(rows: NDArray[Any]) -> list[bytes]:
    written, size = rows.tobytes(), rows.dtype.itemsize
    return [written[at : at + size] for at in range(0, len(written), size)]
