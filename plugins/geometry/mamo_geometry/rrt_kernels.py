"""Compiled RRT-Connect (Kuffner and LaValle, ICRA 2000) with goal sets, and shortcutting."""

from __future__ import annotations

import numpy as np
from numba import njit

from mamo_core.types.geometry import Array, IntArray
from mamo_geometry.arrays import ChainArrays, SphereArrays, WorldArrays
from mamo_geometry.kernels import edge_is_free

_STEP = 0.25


@njit(cache=True)
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


@njit(cache=True)
def _distance(chain: ChainArrays, a: Array, b: Array) -> float:
    total = 0.0
    for j in range(a.shape[0]):
        d = (a[j] - b[j]) * chain.reach[j]
        total += d * d
    return np.sqrt(total)


@njit(cache=True)
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


@njit(cache=True)
def connect(
    chain: ChainArrays,
    s: SphereArrays,
    w: WorldArrays,
    start: Array,
    goals: Array,
    low: Array,
    high: Array,
    rng: np.random.Generator,
    max_checks: int,
    checks: IntArray,
) -> tuple[Array, int]:
    """A path (k, dof) and the number of the goal it reaches, or an empty path and -1.

    ``start`` and ``goals`` (m, dof) must be free. Samples within ``low``..``high`` (dof,).
    """
    dof, roots = start.shape[0], goals.shape[0]
    room = max_checks // 2 + roots + 16
    nodes = np.empty((2, min(room, 60_000), dof))
    parents = np.full((2, nodes.shape[1]), -1, dtype=np.int64)
    counts = np.array([1, roots])
    nodes[0, 0] = start
    nodes[1, :roots] = goals
    R, p = np.empty((dof, 3, 3)), np.empty((dof, 3))
    near = np.empty(w.centre.shape[0], dtype=np.int64)
    q = np.empty(dof)
    grow = 0
    first = True
    while checks[0] < max_checks and max(counts[0], counts[1]) < nodes.shape[1] - 2:
        other = 1 - grow
        if first:
            # Often the straight line to the nearest goal is all it takes.
            q[:] = goals[_nearest(chain, goals, roots, start)]
            first = False
        else:
            for j in range(dof):
                q[j] = low[j] + rng.random() * (high[j] - low[j])
        near_node = _nearest(chain, nodes[grow], counts[grow], q)
        before = counts[grow]
        counts[grow], _ = _extend(
            chain, s, w, nodes[grow], parents[grow], before, near_node, q, R, p, near, checks
        )
        if counts[grow] > before:
            q[:] = nodes[grow, before]
            at = _nearest(chain, nodes[other], counts[other], q)
            while checks[0] < max_checks and counts[other] < nodes.shape[1] - 2:
                had = counts[other]
                counts[other], met = _extend(
                    chain, s, w, nodes[other], parents[other], had, at, q, R, p, near, checks
                )
                if counts[other] == had:
                    break
                at = had
                if met:
                    mine, theirs = (before, at) if grow == 0 else (at, before)
                    return _joined(nodes, parents, mine, theirs)
        grow = other
    return np.empty((0, dof)), -1


@njit(cache=True)
def _joined(nodes: Array, parents: IntArray, mine: int, theirs: int) -> tuple[Array, int]:
    """The path through start-tree node ``mine`` and goal-tree node ``theirs`` (the same place)."""
    length = 0
    n = mine
    while n >= 0:
        length += 1
        n = parents[0, n]
    behind = 0
    n = parents[1, theirs]
    while n >= 0:
        behind += 1
        n = parents[1, n]
    path = np.empty((length + behind, nodes.shape[2]))
    n, k = mine, length - 1
    while n >= 0:
        path[k] = nodes[0, n]
        n, k = parents[0, n], k - 1
    n, k = parents[1, theirs], length
    goal = theirs
    while n >= 0:
        path[k] = nodes[1, n]
        goal = n
        n, k = parents[1, n], k + 1
    return path, goal


@njit(cache=True)
def shortcut(
    chain: ChainArrays,
    s: SphereArrays,
    w: WorldArrays,
    path: Array,
    tries: int,
    rng: np.random.Generator,
    checks: IntArray,
) -> Array:
    """The path with stretches replaced by straight free edges, ``tries`` times at random."""
    dof = path.shape[1]
    R, p = np.empty((dof, 3, 3)), np.empty((dof, 3))
    near = np.empty(w.centre.shape[0], dtype=np.int64)
    # Each success adds at most two corners.
    room = path.shape[0] + 2 * tries
    current, fresh = np.empty((room, dof)), np.empty((room, dof))
    a, b = np.empty(dof), np.empty(dof)
    count = path.shape[0]
    current[:count] = path
    for _ in range(tries):
        if count < 3:
            break
        first, second = rng.random() * (count - 1), rng.random() * (count - 1)
        u, v = min(first, second), max(first, second)
        i, j = min(int(u), count - 2), min(int(v), count - 2)
        if i == j:
            continue
        for k in range(dof):
            a[k] = current[i, k] + (u - i) * (current[i + 1, k] - current[i, k])
            b[k] = current[j, k] + (v - j) * (current[j + 1, k] - current[j, k])
        if not edge_is_free(chain, s, w, a, b, R, p, near, checks):
            continue
        fresh[: i + 1] = current[: i + 1]
        fresh[i + 1] = a
        fresh[i + 2] = b
        rest = count - j - 1
        fresh[i + 3 : i + 3 + rest] = current[j + 1 : count]
        count = i + 3 + rest
        current, fresh = fresh, current
    return current[:count].copy()
