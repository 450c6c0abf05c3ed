"""Compiled RRT-Connect (Kuffner and LaValle, ICRA 2000) with goal sets, and shortcutting."""

from __future__ import annotations

import numpy as np
from numba import njit

from mamo_core.types.geometry import Array, IntArray
from mamo_geometry.arrays import ChainArrays, SphereArrays, WorldArrays
from mamo_geometry.ik_kernels import copy_row
from mamo_geometry.kernels import edge_is_free

_STEP = 0.25


@njit(cache=True, error_model="numpy")
def _nearest(chain: ChainArrays, nodes: Array, count: int, q: Array) -> int:
    best, least = 0, np.inf
    for n in range(count):
        total = 0.0
        for j in range(q.shape[0]):
            d = (nodes[n, j] - q[j]) * chain.reach[j]
            total += d * d
        if total < least:
            best, least = n, total
    return best


@njit(cache=True, error_model="numpy")
def _distance(chain: ChainArrays, a: Array, b: Array) -> float:
    total = 0.0
    for j in range(a.shape[0]):
        d = (a[j] - b[j]) * chain.reach[j]
        total += d * d
    return np.sqrt(total)


@njit(cache=True, error_model="numpy")
def _extend(
    chain: ChainArrays,
    s: SphereArrays,
    w: WorldArrays,
    nodes: Array,
    parents: IntArray,
    count: int,
    from_node: int,
    q: Array,
    R: Array,
    p: Array,
    near: IntArray,
    checks: IntArray,
) -> tuple[int, bool]:
    """One step from ``from_node`` towards ``q``: the new count, and whether ``q`` was reached."""
    gap = _distance(chain, nodes[from_node], q)
    fraction = min(1.0, _STEP / gap) if gap > 0.0 else 1.0
    new = nodes[count]
    for j in range(q.shape[0]):
        new[j] = nodes[from_node, j] + fraction * (q[j] - nodes[from_node, j])
    if not edge_is_free(chain, s, w, nodes[from_node], new, R, p, near, checks):
        return count, False
    parents[count] = from_node
    return count + 1, fraction == 1.0


@njit(cache=True, error_model="numpy")
def connect(
    chain: ChainArrays,
    s: SphereArrays,
    w: WorldArrays,
    nodes: Array,
    parents: IntArray,
    roots: int,
    low: Array,
    high: Array,
    rng: np.random.Generator,
    max_checks: int,
    checks: IntArray,
) -> tuple[int, int]:
    """Grow the trees until they meet: the two nodes that stand in the same place, or -1, -1.

    ``nodes`` (2, n, dof) and ``parents`` (2, n): tree 0 starts with one node, tree 1 with ``roots``
    goals, all of them free and with parent -1. Samples within ``low``..``high`` (dof,).
    """
    dof, room = nodes.shape[2], nodes.shape[1] - 2
    counts = np.empty(2, dtype=np.int64)
    counts[0], counts[1] = 1, roots
    R, p = np.empty((dof + 1, 3, 3)), np.empty((dof + 1, 3))
    near = np.empty(2 * w.centre.shape[0], dtype=np.uintp)
    q = np.empty(dof)
    # Often the straight line to the nearest goal is all it takes.
    copy_row(nodes[1], _nearest(chain, nodes[1], roots, nodes[0, 0]), q)
    grow = 0
    while checks[0] < max_checks and max(counts[0], counts[1]) < room:
        other = 1 - grow
        before = counts[grow]
        from_node = _nearest(chain, nodes[grow], before, q)
        counts[grow], _ = _extend(
            chain, s, w, nodes[grow], parents[grow], before, from_node, q, R, p, near, checks
        )
        if counts[grow] > before:
            copy_row(nodes[grow], before, q)
            at = _nearest(chain, nodes[other], counts[other], q)
            while checks[0] < max_checks and counts[other] < room:
                had = counts[other]
                counts[other], met = _extend(
                    chain, s, w, nodes[other], parents[other], had, at, q, R, p, near, checks
                )
                if counts[other] == had:
                    break
                at = had
                if met:
                    return (before, at) if grow == 0 else (at, before)
        grow = other
        for j in range(dof):
            q[j] = low[j] + rng.random() * (high[j] - low[j])
    return -1, -1


@njit(cache=True, error_model="numpy")
def shortcut(
    chain: ChainArrays,
    s: SphereArrays,
    w: WorldArrays,
    current: Array,
    fresh: Array,
    count: int,
    tries: int,
    rng: np.random.Generator,
    checks: IntArray,
) -> tuple[int, bool]:
    """Replace stretches of a path by straight free edges, ``tries`` times at random.

    The path is the first ``count`` rows of ``current`` (n, dof); ``fresh`` is as large, with room
    for two more corners a try. Returns the new count, and whether the result is in ``fresh``.
    """
    dof = current.shape[1]
    R, p = np.empty((dof + 1, 3, 3)), np.empty((dof + 1, 3))
    near = np.empty(2 * w.centre.shape[0], dtype=np.uintp)
    a, b = np.empty(dof), np.empty(dof)
    swapped = False
    for _ in range(tries):
        if count < 3:
            break
        one, two = rng.random() * (count - 1), rng.random() * (count - 1)
        u, v = min(one, two), max(one, two)
        i, j = min(int(u), count - 2), min(int(v), count - 2)
        if i == j:
            continue
        for k in range(dof):
            a[k] = current[i, k] + (u - i) * (current[i + 1, k] - current[i, k])
            b[k] = current[j, k] + (v - j) * (current[j + 1, k] - current[j, k])
        if not edge_is_free(chain, s, w, a, b, R, p, near, checks):
            continue
        count = _spliced(current, fresh, count, i, j, a, b)
        current, fresh = fresh, current
        swapped = not swapped
    return count, swapped


@njit(cache=True, error_model="numpy")
def _spliced(current: Array, fresh: Array, count: int, i: int, j: int, a: Array, b: Array) -> int:
    """Write ``current[: i + 1], a, b, current[j + 1 : count]`` into ``fresh``; its length."""
    dof = current.shape[1]
    for k in range(dof):
        for n in range(i + 1):
            fresh[n, k] = current[n, k]
        fresh[i + 1, k] = a[k]
        fresh[i + 2, k] = b[k]
        for n in range(j + 1, count):
            fresh[i + 2 + n - j, k] = current[n, k]
    return i + 2 + count - j
