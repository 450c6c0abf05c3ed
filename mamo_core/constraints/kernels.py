"""Compiled glances: every step is looked at, so one look must cost about a microsecond."""

from __future__ import annotations

import numpy as np
from numba import njit

from mamo_core.types.geometry import Array, BoolArray, IntArray
from mamo_core.types.rollout import NO_CONTACTS, NO_DEPTHS


@njit(cache=True)
def within(
    positions: Array,
    z_axes: Array,
    velocities: Array,
    contacts: IntArray,
    depths: Array,
    bounds: Array,
    forbidden: BoolArray,
    deepest: float,
    gripped: int,
) -> bool:
    """Whether a step is within some limits.

    ``bounds`` (n, 6), of each object: lowest height, axis, least cosine, largest square of the
    speed. ``forbidden`` (e, e). ``deepest``: m; ``gripped``: entity that the hand may press harder,
    or -1. The rest is as in ``StepObservation``.
    """
    for i in range(positions.shape[0]):
        if bounds[i, 0] - positions[i, 2] > 0.0:
            return False
        cosine, square = 0.0, 0.0
        for k in range(3):
            cosine += z_axes[i, k] * bounds[i, 1 + k]
            square += velocities[i, k] ** 2
        if cosine < bounds[i, 4] or square > bounds[i, 5]:
            return False
    for n in range(contacts.shape[0]):
        first, second = contacts[n, 0], contacts[n, 1]
        pressed = depths[n] > deepest and not (first == 0 and second == gripped)
        if forbidden[first, second] or pressed:
            return False
    return True


@njit(cache=True)
def largest_gap(values: Array, reference: Array) -> float:
    """Largest absolute difference between two arrays (n,)."""
    gap = 0.0
    for i in range(values.shape[0]):
        gap = max(gap, abs(values[i] - reference[i]))
    return gap


def warm_up() -> None:
    """Compile the glances for the arrays that engines show (or read them from numba's cache)."""
    rows, bounds = np.zeros((2, 3)), np.zeros((2, 6))
    forbidden = np.zeros((1, 1), dtype=np.bool_)
    for positions in (rows, np.zeros((2, 7))[:, :3]):
        within(positions, rows, rows, NO_CONTACTS, NO_DEPTHS, bounds, forbidden, 0.0, -1)
    writable, frozen = np.zeros(1), np.zeros(1)
    frozen.flags.writeable = False
    largest_gap(writable, writable)
    largest_gap(writable, frozen)
