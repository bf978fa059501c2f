"""Recordings with everything that real ones have, and chains that take them either way."""

import dataclasses

import numpy as np

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.blocks import BLOCKS, ImuBlock, Stamped
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rotation import quaternion_from_euler
from dead_reckoning.core.samples import NOT_MEASURED, UNKNOWN, ImuSample

START_NS = 1_700_000_000_000_000_000
RESTART_NS = 20_000_000_000
GAP_NS = 700_000_000
LONG_GAP_NS = 2_000_000_000
NAN = float('nan')

EAGER = {
    'pedometer.rhythm.open': 0.01,
    'pedometer.rhythm.centre': 0.0,
    'pedometer.rhythm.likeness': -1.0,
}
"""Settings with which the short movements of `recording` are steps."""


def recording(seed, seconds=10.0, rate=100, gyro=False, orientation=False, odd=0.01):
    """Return samples of rests and movements in turn, a part of which, ``odd``, is not regular."""
    random = np.random.default_rng(seed)
    count = round(seconds * rate)
    time = np.arange(count) / rate
    moving = np.sin(2.0 * np.pi * time / 5.0 + 4.0) > 0.3
    pushes = random.uniform(0.5, 2.0, 3) * np.sin(2.0 * np.pi * time[:, None] * [0.8, 1.1, 1.9])
    forces = random.normal(0.0, 0.03, (count, 3)) + random.uniform(-0.3, 0.3, 3)
    forces += np.where(moving[:, None], pushes, 0.0)
    forces[:, 2] += 9.8
    rates = random.normal(0.0, 0.003, (count, 3)) + random.normal(0.0, 0.01, 3)
    rates += np.where(moving[:, None], 0.4 * pushes, 0.0)
    noises = [UNKNOWN, *(covariance(random, 0.01) for _ in range(3))]
    tilts = [UNKNOWN, *(covariance(random, 1e-3) for _ in range(3))]
    stamp_ns, samples = START_NS, []
    noise, tilt = noises[1], tilts[1]
    for index in range(count):
        stamp_ns += round(1e9 / rate) + int(random.integers(-200_000, 200_000))
        if random.random() < 0.01:
            noise, tilt = noises[random.integers(4)], tilts[random.integers(4)]
        values = {}
        if gyro:
            values |= {'angular_velocity': tuple(rates[index].tolist())}
            values |= {'angular_velocity_covariance': noise}
        if orientation:
            turn = quaternion_from_euler(
                *(0.2 * np.sin(0.3 * time[index] + np.arange(3))).tolist()
            )
            longer = 1.0 + random.choice([0.0, 1e-7])
            values |= {'orientation': tuple(longer * q for q in turn)}
            values |= {'orientation_covariance': tilt}
        force = tuple(forces[index].tolist())
        sample = ImuSample(stamp_ns, 'imu_link', force, noise, **values)
        if index > rate and random.random() < odd:
            sample = made_odd(random, sample, gyro, orientation)
            if sample.stamp_ns - stamp_ns in (-RESTART_NS, GAP_NS, LONG_GAP_NS):
                stamp_ns = sample.stamp_ns  # the time goes on from there
        samples.append(sample)
    return samples


def made_odd(random, sample, gyro, orientation):
    """Return a sample with one of the faults that samples have."""
    stamp_ns, force = sample.stamp_ns, sample.specific_force
    changes = [
        {'specific_force': (NAN, *force[1:])},
        {'specific_force': (force[0], 1e7, force[2])},
        {'specific_force_covariance': NOT_MEASURED},
        {'specific_force_covariance': (1.0, 5.0, 0.0) * 3},
        {'specific_force_covariance': (NAN,) * 9},
        {'stamp_ns': 0},
        {'stamp_ns': stamp_ns - 10_000_000},  # the stamp before, or about it
        {'stamp_ns': stamp_ns - 300_000_000},
        {'stamp_ns': stamp_ns - RESTART_NS},
        {'stamp_ns': stamp_ns + GAP_NS},
        {'stamp_ns': stamp_ns + LONG_GAP_NS},
    ]
    if gyro:
        changes += [
            {'angular_velocity': None, 'angular_velocity_covariance': UNKNOWN},
            {'angular_velocity': (0.0, NAN, 0.0)},
            {'angular_velocity_covariance': (1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0)},
        ]
    if orientation:
        changes += [
            {'orientation': None, 'orientation_covariance': UNKNOWN},
            {'orientation': (0.0, 0.0, 0.0, 0.0)},
            {'orientation': (NAN, 0.0, 0.0, 1.0)},
            {'orientation': (0.0, 0.0, 2.0, 2.0)},
            {'orientation_covariance': (1.0,) * 8 + (-1.0,)},
        ]
    return dataclasses.replace(sample, **changes[random.integers(len(changes))])


def covariance(random, size):
    """Return a covariance, shape (3, 3)."""
    root = random.normal(0.0, size, (3, 3))
    return tuple((root @ root.T).ravel().tolist())


def streamed(values, name, samples):
    """Return what a chain makes of samples one by one: by name, pairs of stamp and value."""
    chain, found = Pipeline(Configuration(values)).chain, {}
    for sample in samples:
        for output, value in chain.push(name, sample):
            found.setdefault(output, []).append((sample.stamp_ns, value))
    return found


def in_blocks(values, name, samples, cuts):
    """Return the same of a chain that takes blocks, cut at these indices."""
    chain, found = Pipeline(Configuration(values), blocks=True).chain, {}
    for begin, end in zip([0, *cuts], [*cuts, len(samples)], strict=True):
        for output, value in chain.push(name, ImuBlock.of(samples[begin:end])):
            if isinstance(value, Stamped):
                assert type(value.value) not in BLOCKS  # those come in blocks
                pairs = [(value.stamp_ns, value.value)]
            else:
                pairs = [(None, value.sample(k)) for k in range(len(value))]
            found.setdefault(output, []).extend(pairs)
    return found


def assert_same(batch, stream, tolerance=1e-9):
    """Compare outputs by name: samples to a part of their scale, all else as it is written."""
    assert batch.keys() == stream.keys()
    for name, pairs in stream.items():
        assert len(batch[name]) == len(pairs), name
        kind = type(pairs[0][1])
        if kind in BLOCKS:
            found, expected = (
                BLOCKS[kind].of([value for _, value in each[name]]) for each in (batch, stream)
            )
            assert_same_columns(found, expected, tolerance)
        else:
            assert by_text(batch[name]) == by_text(pairs)


def by_text(pairs):
    """Order by text: faults of several stages mingle as they like."""
    return sorted((repr(value), stamp) for stamp, value in pairs)


def assert_same_columns(found, expected, tolerance):
    for field in dataclasses.fields(expected):
        ours, theirs = getattr(found, field.name), getattr(expected, field.name)
        if dataclasses.is_dataclass(theirs):
            assert_same_columns(ours, theirs, tolerance)
        elif theirs is None or isinstance(theirs, str) or theirs.dtype.kind != 'f':
            np.testing.assert_array_equal(ours, theirs, err_msg=field.name)
        else:
            scale = np.abs(theirs).max(axis=1, keepdims=True)
            wrong = np.abs(ours - theirs) > tolerance * np.maximum(scale, 1e-9)
            assert not wrong.any(), (field.name, np.argwhere(wrong)[:3])
