"""Compiled reading of the engine's arrays after every step."""

from __future__ import annotations

import numpy as np
from numba import njit

from mamo_core.types.geometry import Array, IntArray


@njit(cache=True)
def observe(
    xpos: Array, xmat: Array, qvel: Array, bodies: IntArray, free: IntArray, free_qvel: IntArray
) -> tuple[Array, Array, Array]:
    """Positions (n, 3), z axes (n, 3) and velocities (n, 3) of the objects."""
    count = bodies.shape[0]
    positions, axes, velocities = np.empty((count, 3)), np.empty((count, 3)), np.zeros((count, 3))
    for i in range(count):
        for k in range(3):
            positions[i, k] = xpos[bodies[i], k]
            axes[i, k] = xmat[bodies[i], 3 * k + 2]
    for m in range(free.shape[0]):
        for k in range(3):
            velocities[free[m], k] = qvel[free_qvel[m] + k]
    return positions, axes, velocities


@njit(cache=True)
def contact_pairs(geoms: IntArray, entity: IntArray) -> IntArray:
    """Entity pairs (k, 2), ascending, of contacts given as geom pairs."""
    pairs = np.empty((geoms.shape[0], 2), dtype=np.int64)
    for n in range(geoms.shape[0]):
        a, b = entity[geoms[n, 0]], entity[geoms[n, 1]]
        pairs[n, 0], pairs[n, 1] = min(a, b), max(a, b)
    return pairs


@njit(cache=True)
def at_rest(qvel: Array, free_qvel: IntArray, speed: float, spin: float) -> bool:
    """Whether every component of all velocities (m/s) and spins (rad/s) is below its bound."""
    for m in range(free_qvel.shape[0]):
        for k in range(3):
            if abs(qvel[free_qvel[m] + k]) >= speed or abs(qvel[free_qvel[m] + 3 + k]) >= spin:
                return False
    return True


def warm_up() -> None:
    """Compile the kernels (or read them from numba's cache)."""
    one = np.zeros(1, dtype=np.int64)
    rows, matrix, flat = np.zeros((1, 3)), np.zeros((1, 9)), np.zeros(6)
    observe(rows, matrix, flat, one, one, one)
    contact_pairs(np.zeros((1, 2), dtype=np.int32), one)
    at_rest(flat, one, 1.0, 1.0)
