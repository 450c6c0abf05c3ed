"""Compiled screens: constraints look at every step, so one look must cost about a microsecond."""

from __future__ import annotations

import numpy as np
from numba import njit

from mamo_core.types.geometry import Array


@njit(cache=True)
def least_cosine(axes: Array, reference: Array) -> float:
    """Smallest dot product of corresponding rows of two arrays (n, 3)."""
    least = 1.0
    for i in range(axes.shape[0]):
        dot = 0.0
        for k in range(3):
            dot += axes[i, k] * reference[i, k]
        least = min(least, dot)
    return least


@njit(cache=True)
def largest_square(vectors: Array) -> float:
    """Largest squared norm of the rows of an array (n, 3)."""
    largest = 0.0
    for i in range(vectors.shape[0]):
        square = vectors[i, 0] ** 2 + vectors[i, 1] ** 2 + vectors[i, 2] ** 2
        largest = max(largest, square)
    return largest


@njit(cache=True)
def deepest(positions: Array, lowest: Array) -> float:
    """How far the z of positions (n, 3) is at most below ``lowest`` (n,); negative if above."""
    depth = -np.inf
    for i in range(positions.shape[0]):
        depth = max(depth, lowest[i] - positions[i, 2])
    return depth


@njit(cache=True)
def largest_gap(values: Array, reference: Array) -> float:
    """Largest absolute difference between two arrays (n,)."""
    gap = 0.0
    for i in range(values.shape[0]):
        gap = max(gap, abs(values[i] - reference[i]))
    return gap


def warm_up() -> None:
    """Compile the screens (or read them from numba's cache)."""
    rows = np.zeros((1, 3))
    least_cosine(rows, rows)
    largest_square(rows)
    deepest(rows, rows[:, 0].copy())
    writable, frozen = np.zeros(1), np.zeros(1)
    frozen.flags.writeable = False
    largest_gap(writable, writable)
    largest_gap(writable, frozen)
