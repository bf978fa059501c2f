"""Many samples at once: a sample's fields as columns, for work on whole recordings.

A block has the fields of its sample, each an array with a row per sample, vectors (n, 3),
quaternions (n, 4), matrices (n, 9), in the units and frames of the sample; the frame's name is one
for all.  What a sample does not measure (None) is a row of zeros whose covariance starts with −1,
as in a message (REP-145).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.gravity import Levelled
from dead_reckoning.core.samples import (
    NOT_MEASURED,
    UNKNOWN,
    ImuSample,
    LinearAcceleration,
    NavigationState,
)

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]
Flags = NDArray[np.bool_]

Sample = TypeVar('Sample')
Itself = TypeVar('Itself', bound='Block[Any]')

OPTIONAL = {
    'angular_velocity': 'angular_velocity_covariance',
    'orientation': 'orientation_covariance',
}
"""What a sample may not measure, and the covariance that says so in a block."""

CROSS = ('pose_cross_covariance', 'twist_cross_covariance')
"""What a block has not where it is zero."""

WIDTHS = {'orientation': 4, 'angular_velocity': 3}


class Block(Generic[Sample]):
    """What blocks have in common: a length, parts, and the way from samples and back."""

    __slots__ = ()
    SAMPLE: ClassVar[type]
    stamp_ns: Stamps

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.stamp_ns)

    def part(self: Itself, begin: int, end: int) -> Itself:
        """Return the samples from one to before another, as views."""
        return type(self)(
            **{
                name: value if isinstance(value, str) else value[begin:end]
                for name, value in self._columns()
                if value is not None
            }
        )

    @classmethod
    def of(cls: type[Itself], samples: Sequence[Any]) -> Itself:
        """Return samples, at least one, as a block."""
        columns: dict[str, Any] = {}
        for field in fields(cls):  # type: ignore[arg-type]
            name = field.name
            if name == 'frame_id':
                columns[name] = samples[0].frame_id
            elif name in CROSS:
                values = [getattr(s, name) for s in samples]
                columns[name] = None if all(v is UNKNOWN for v in values) else np.array(values)
            elif name in OPTIONAL:
                nothing = (0.0,) * WIDTHS[name]
                columns[name] = np.array([getattr(s, name) or nothing for s in samples])
            else:
                columns[name] = np.array([getattr(s, name) for s in samples])
        for name, covariance in OPTIONAL.items():
            if name in columns:
                missing = [getattr(s, name) is None for s in samples]
                columns[covariance][missing] = NOT_MEASURED
        return cls(**columns)

    @classmethod
    def join(cls: type[Itself], blocks: Sequence[Itself]) -> Itself:
        """Return blocks, at least one, as one; a single one as it is."""
        if len(blocks) == 1:
            return blocks[0]
        columns: dict[str, Any] = {}
        for name, value in blocks[0]._columns():
            parts = [getattr(block, name) for block in blocks]
            if isinstance(value, str):
                columns[name] = value
            elif any(part is not None for part in parts):
                columns[name] = np.concatenate(
                    [
                        np.zeros((len(block), 9)) if part is None else part
                        for block, part in zip(blocks, parts, strict=True)
                    ]
                )
        return cls(**columns)

    def sample(self, index: int) -> Sample:
        """Return one sample."""
        values: dict[str, Any] = {}
        for name, column in self._columns():
            if isinstance(column, str):
                values[name] = column
            elif column is not None:
                value = column[index].tolist()
                values[name] = tuple(value) if isinstance(value, list) else value
        for name, covariance in OPTIONAL.items():
            if name in values and values[covariance][0] < 0.0:
                values[name], values[covariance] = None, UNKNOWN
        made: Sample = self.SAMPLE(**values)
        return made

    def _columns(self) -> list[tuple[str, Any]]:
        return [(field.name, getattr(self, field.name)) for field in fields(self)]  # type: ignore[arg-type]


@dataclass(frozen=True, slots=True, eq=False)
class ImuBlock(Block[ImuSample]):
    """Columns of `ImuSample`."""

    SAMPLE = ImuSample

    stamp_ns: Stamps
    frame_id: str
    specific_force: Array
    specific_force_covariance: Array
    angular_velocity: Array
    angular_velocity_covariance: Array
    orientation: Array
    orientation_covariance: Array


@dataclass(frozen=True, slots=True, eq=False)
class AccelerationBlock(Block[LinearAcceleration]):
    """Columns of `LinearAcceleration`."""

    SAMPLE = LinearAcceleration

    stamp_ns: Stamps
    frame_id: str
    acceleration: Array
    covariance: Array


@dataclass(frozen=True, slots=True, eq=False)
class StateBlock(Block[NavigationState]):
    """Columns of `NavigationState`."""

    SAMPLE = NavigationState

    stamp_ns: Stamps
    position: Array
    velocity: Array
    attitude: Array
    position_covariance: Array
    velocity_covariance: Array
    attitude_covariance: Array
    angular_velocity: Array
    angular_velocity_covariance: Array
    stationary: Flags
    pose_cross_covariance: Array | None = None
    """None where it is zero, as for all estimators but the inertial navigator."""
    twist_cross_covariance: Array | None = None


@dataclass(frozen=True, slots=True, eq=False)
class LevelledBlock:
    """Columns of `Levelled`."""

    imu: ImuBlock
    acceleration: AccelerationBlock

    @property
    def stamp_ns(self) -> Stamps:
        """Stamps of the samples, shape (n,) [ns]."""
        return self.imu.stamp_ns

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.imu)

    def sample(self, index: int) -> Levelled:
        """Return one sample."""
        return Levelled(self.imu.sample(index), self.acceleration.sample(index))

    def part(self, begin: int, end: int) -> LevelledBlock:
        """Return the samples from one to before another, as views."""
        return LevelledBlock(self.imu.part(begin, end), self.acceleration.part(begin, end))

    @classmethod
    def of(cls, samples: Sequence[Levelled]) -> LevelledBlock:
        """Return samples, at least one, as a block."""
        return cls(
            ImuBlock.of([s.imu for s in samples]),
            AccelerationBlock.of([s.acceleration for s in samples]),
        )

    @classmethod
    def join(cls, blocks: Sequence[LevelledBlock]) -> LevelledBlock:
        """Return blocks, at least one, as one; a single one as it is."""
        if len(blocks) == 1:
            return blocks[0]
        return cls(
            ImuBlock.join([block.imu for block in blocks]),
            AccelerationBlock.join([block.acceleration for block in blocks]),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Stamped:
    """What has no stamp of its own, with that of the sample that brought it [ns]."""

    stamp_ns: int
    value: Any


@dataclass(frozen=True)
class Listed:
    """Samples of a kind that has no columns, as they are few: at least one."""

    samples: Sequence[Any]

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.samples)

    @property
    def stamp_ns(self) -> list[int]:
        """Their stamps [ns]."""
        return [sample.stamp_ns for sample in self.samples]

    def sample(self, index: int) -> Any:
        """Return one of them."""
        return self.samples[index]


BLOCKS: dict[type, Any] = {
    ImuSample: ImuBlock,
    LinearAcceleration: AccelerationBlock,
    NavigationState: StateBlock,
    Levelled: LevelledBlock,
}
"""The block of each kind of sample."""

ANY_BLOCK = (Block, LevelledBlock)
"""Classes of all blocks."""
