"""Go back through what the filter did, so that each state knows all samples."""

from __future__ import annotations

import numpy as np

from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import Array, triple
from dead_reckoning.core.kernels.navigation.filter import put_state
from dead_reckoning.core.kernels.navigation.layout import (
    AVERAGING,
    CLONE,
    ERRORS,
    FLOOR,
    FOLLOW,
    FORGET,
    GRAVITY,
    TRACE_ROW,
    TURN,
    X,
)
from dead_reckoning.core.kernels.navigation.measurement import (
    correct,
    turn_both,
    turn_errors,
)
from dead_reckoning.core.kernels.navigation.strapdown import carry_back, transpose

PUBLISHED = 12
"""Errors whose covariance comes out."""


@compiled
def smooth(
    trace: Array, log: Array, rules: Array, adjoint: Array, information: Array, out: Array
) -> None:
    """Smooth a stretch of samples by the modified Bryson–Frazier recursion.

    ``adjoint``, shape (16, 1), and ``information``, shape (16, 16), are those of what comes after,
    zeros at the end; they become those of what comes before.  ``out`` gets the smoothed states;
    what the detector said of them stays.  For each update, C = I − K H, backward,

    λ ← Cᵀ λ − Hᵀ S⁻¹ y,  Λ ← Cᵀ Λ C + Hᵀ S⁻¹ H,  for each step λ ← Fᵀ λ, Λ ← Fᵀ Λ F,

    and x̂ − P λ, P − P Λ P are the smoothed ones.  G. J. Bierman, *Fixed interval smoothing with
    discrete measurements*, Int. J. Control 18, 1973, doi:10.1080/00207177308932487.
    """
    gravity, dx, x = rules[GRAVITY], np.zeros(ERRORS), np.zeros(X)
    half, smoothed = np.zeros((ERRORS, PUBLISHED)), np.zeros((PUBLISHED, PUBLISHED))
    for k in range(len(trace) - 1, -1, -1):
        row = trace[k]
        p = row[16 + X : 16 + X + ERRORS * ERRORS].reshape((ERRORS, ERRORS))
        for i in range(ERRORS):
            dx[i] = 0.0
            for j in range(ERRORS):
                dx[i] -= p[i, j] * adjoint[j, 0]
        for i in range(X):
            x[i] = row[16 + i]
        correct(x, dx)
        _shrink(p, information, half, smoothed)
        rate, noise = triple(row[TRACE_ROW - 5 : TRACE_ROW - 2]), row[TRACE_ROW - 2]
        put_state(out[k], x, smoothed, rate, noise, 0.5 * rules[AVERAGING] * row[0])
        begin = int(trace[k - 1, TRACE_ROW - 1]) if k > 0 else 0
        for m in range(int(row[TRACE_ROW - 1]) - 1, begin - 1, -1):
            _undo(log[m], adjoint, information)
        rot = (row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9])
        way, v = triple(row[10:13]), triple(row[13:16])
        carry_back(adjoint, row[0], gravity, rot, way, v)
        carry_back(information, row[0], gravity, rot, way, v)
        transpose(information)
        carry_back(information, row[0], gravity, rot, way, v)


def _shrink(p: Array, information: Array, half: Array, smoothed: Array) -> None:
    """Write the first rows and columns of P − P Λ P."""
    n = len(smoothed)
    for i in range(ERRORS):
        for j in range(n):
            total = 0.0
            for k in range(ERRORS):
                total += information[i, k] * p[k, j]
            half[i, j] = total
    for i in range(n):
        for j in range(i, n):
            total = p[i, j]
            for k in range(ERRORS):
                total -= p[i, k] * half[k, j]
            smoothed[i, j] = smoothed[j, i] = total


def _undo(entry: Array, adjoint: Array, information: Array) -> None:
    """Go back over one entry of the log."""
    what, gain, h = int(entry[0]), entry[3 : 3 + ERRORS], entry[3 + ERRORS :]
    if what == FORGET:
        for a in range(ERRORS):
            if h[a] != 0.0:
                adjoint[a, 0] = 0.0
                for b in range(ERRORS):
                    information[a, b] = information[b, a] = 0.0
    elif what == CLONE:  # the floor was the height: what is known of it goes there
        adjoint[2, 0] += adjoint[FLOOR, 0]
        adjoint[FLOOR, 0] = 0.0
        for a in range(ERRORS):
            information[2, a] += information[FLOOR, a]
        for a in range(ERRORS):
            information[a, 2] += information[a, FLOOR]
        for a in range(ERRORS):
            information[FLOOR, a] = information[a, FLOOR] = 0.0
    elif what in (TURN, FOLLOW):
        turn = (-entry[1], -entry[2], -entry[3])
        turn_errors(adjoint, what, turn)
        turn_both(information, what, turn)
    else:
        _unmeasure(entry[1], entry[2], gain, h, adjoint, information)


def _unmeasure(
    total: float, innovation: float, gain: Array, h: Array, adjoint: Array, information: Array
) -> None:
    """Go back over a measurement of H · errors."""
    along, across = innovation / total, np.zeros(ERRORS)
    weight = 1.0 / total
    for a in range(ERRORS):
        along += gain[a] * adjoint[a, 0]
        for b in range(ERRORS):
            across[a] += information[a, b] * gain[b]
        weight += across[a] * gain[a]
    for i in range(ERRORS):
        if h[i] != 0.0:
            adjoint[i, 0] -= h[i] * along
            for a in range(ERRORS):
                information[i, a] += h[i] * (weight * h[a] - across[a])
                information[a, i] -= h[i] * across[a]
