"""Compiled reading of the engine's arrays after every step."""

from __future__ import annotations

import numpy as np
from numba import njit

from mamo_core.types.geometry import Array, IntArray


@njit(cache=True)
def command(ctrl: Array, positions: Array, velocities: Array, lead: float, drive: float) -> None:
    """Servos of the arm get where it should be ``lead`` seconds later, all others ``drive``."""
    dof = positions.shape[0]
    for i in range(dof):
        ctrl[i] = positions[i] + lead * velocities[i]
    for i in range(dof, ctrl.shape[0]):
        ctrl[i] = drive


@njit(cache=True)
def observe(xpos: Array, xmat: Array, qvel: Array, objects: IntArray, seen: Array) -> None:
    """Positions, z axes and velocities of the objects into ``seen`` (3, n, 3).

    ``objects`` (n, 2): of each its body, and its first velocity or -1 if it is fixed.
    """
    for i in range(objects.shape[0]):
        body, first = objects[i, 0], objects[i, 1]
        for k in range(3):
            seen[0, i, k] = xpos[body, k]
            seen[1, i, k] = xmat[body, 3 * k + 2]
            seen[2, i, k] = qvel[first + k] if first >= 0 else 0.0


@njit(cache=True)
def contact_pairs(geoms: IntArray, entity: IntArray, pairs: IntArray) -> None:
    """Entity pairs, ascending, of contacts given as geom pairs (k, 2), into ``pairs`` (k, 2)."""
    for n in range(geoms.shape[0]):
        a, b = entity[geoms[n, 0]], entity[geoms[n, 1]]
        pairs[n, 0], pairs[n, 1] = min(a, b), max(a, b)


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
    frozen = np.zeros(1)
    frozen.flags.writeable = False
    for positions in (np.zeros(1), frozen):
        command(flat, positions, np.zeros(1), 0.0, 0.0)
    observe(rows, matrix, flat, np.zeros((1, 2), dtype=np.int64), np.zeros((3, 1, 3)))
    # Geoms are a part of the engine's records: they are contiguous only if there is just one.
    for count in (1, 2):
        geoms = np.zeros((count, 4), dtype=np.int32)[:, :2]
        contact_pairs(geoms, one, np.zeros((count, 2), dtype=np.int64))
    at_rest(flat, one, 1.0, 1.0)
