"""Filters and derivatives of signals with gaps, sampled at equal distances."""

from __future__ import annotations

from math import ceil, log, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.rotation import matrix_from_quaternion

Array = NDArray[np.float64]

SIGMAS = 4.0


def low_pass(signal: Array, rate: float, cut_off: float) -> Array:
    """Smooth the columns of a signal, shape (n, k), with a Gaussian, without delay.

    ``rate`` [Hz]; at ``cut_off`` [Hz] the amplitude is 1/√2.  Where the Gaussian (cut at four
    sigmas) meets NaN or an end, the result is NaN.
    """
    sigma = sqrt(log(2.0)) / (2.0 * pi * cut_off) * rate
    half = ceil(SIGMAS * sigma)
    weights = np.exp(-0.5 * (np.arange(-half, half + 1) / sigma) ** 2)
    weights /= weights.sum()
    smooth = np.full(signal.shape, np.nan)
    if len(signal) > 2 * half:
        for column in range(signal.shape[1]):
            smooth[half : len(signal) - half, column] = np.convolve(
                signal[:, column], weights, 'valid'
            )
    return smooth


def derivative(signal: Array, rate: float) -> Array:
    """Differentiate by central differences; NaN at the ends and beside NaN."""
    slope = np.full(signal.shape, np.nan)
    slope[1:-1] = (signal[2:] - signal[:-2]) * (0.5 * rate)
    return slope


def second_derivative(signal: Array, rate: float) -> Array:
    """Differentiate twice by central differences; NaN at the ends and beside NaN."""
    curve = np.full(signal.shape, np.nan)
    curve[1:-1] = (signal[2:] - 2.0 * signal[1:-1] + signal[:-2]) * rate**2
    return curve


def root_mean_square(signal: Array) -> float:
    """Return the root mean square of all that is not NaN; NaN if nothing is."""
    known = signal[~np.isnan(signal)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else float('nan')


def rotations(quaternions: Array) -> Array:
    """Turn unit quaternions (x, y, z, w), shape (n, 4), into matrices, shape (n, 3, 3)."""
    x, y, z, w = quaternions.T
    elements = matrix_from_quaternion((x, y, z, w))  # plain arithmetic, so arrays will do
    matrices: Array = np.stack(elements, axis=1).reshape(-1, 3, 3)
    return matrices
