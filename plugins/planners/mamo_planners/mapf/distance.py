"""Cost from every lattice cell of one agent to its goal set (kernels), the A* heuristic."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mamo_planners.mapf.heap import pop_key, push_key
from mamo_planners.mapf.kernel import kernel

Int64Array = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

FAR = np.int64(1 << 60)
"""Cost of what cannot be reached or is forbidden."""

_CELL_BITS = 24


def uniform_distance(free: BoolArray, goal: Int64Array, unit: int) -> Int64Array:
    """Cost (nx, ny) to the cheapest goal where each step costs ``unit``.

    ``goal`` (nx, ny): cost of ending at a cell, ``FAR`` where that is not allowed.
    """
    sources = np.flatnonzero(goal < FAR)
    values = goal.ravel()[sources]
    if len(values) > 0 and values.max() > values.min():
        sources = sources[np.argsort(values, kind="stable")]
    cost = np.full(goal.shape, FAR)
    queue = np.empty(goal.size, dtype=np.int64)
    _spread(free, goal, sources, unit, cost, queue)
    return cost


@kernel
def _spread(
    free: BoolArray,
    goal: Int64Array,
    sources: Int64Array,
    unit: int,
    cost: Int64Array,
    queue: Int64Array,
) -> None:
    """Fills ``cost``: steps cost the same, so a queue is sorted by itself.

    Goals of different costs join it from the list of ``sources``, cheapest first.
    """
    nx, ny = free.shape
    head, tail, source = 0, 0, 0
    while head < tail or source < sources.size:
        take_source = head == tail
        if source < sources.size:
            cell = sources[source]
            x, y = cell // ny, cell % ny
            if not take_source:
                other = queue[head]
                take_source = goal[x, y] <= cost[other // ny, other % ny]
        if take_source:
            source += 1
            if cost[x, y] <= goal[x, y]:
                continue
            cost[x, y] = goal[x, y]
        else:
            cell = queue[head]
            x, y = cell // ny, cell % ny
            head += 1
        following = cost[x, y] + unit
        for move in range(4):
            ox = x + (move == 0) - (move == 1)
            oy = y + (move == 2) - (move == 3)
            if ox < 0 or oy < 0 or ox >= nx or oy >= ny or not free[ox, oy]:
                continue
            # A source not taken yet is worth its own cost: never queue it above that.
            if following < min(cost[ox, oy], goal[ox, oy]):
                cost[ox, oy] = following
                queue[tail] = ox * ny + oy
                tail += 1


def weighted_distance(free: BoolArray, goal: Int64Array, step: Int64Array) -> Int64Array:
    """As ``uniform_distance``, where arriving at a cell costs ``step`` (nx, ny)."""
    cost = goal.copy()
    _spread_weighted(free, step, cost, np.empty(8 * goal.size + 8, dtype=np.int64))
    return cost


@kernel
def _spread_weighted(free: BoolArray, step: Int64Array, cost: Int64Array, heap: Int64Array) -> None:
    """Dijkstra's algorithm from the goals, whose costs ``cost`` holds already."""
    nx, ny = free.shape
    size = 0
    for cell in range(nx * ny):
        if cost[cell // ny, cell % ny] < FAR:
            size = push_key(heap, size, (cost[cell // ny, cell % ny] << _CELL_BITS) | cell)
    while size > 0:
        key, size = pop_key(heap, size)
        cell = key & ((1 << _CELL_BITS) - 1)
        x, y = cell // ny, cell % ny
        if key >> _CELL_BITS > cost[x, y]:
            continue
        following = cost[x, y] + step[x, y]
        for move in range(4):
            ox = x + (move == 0) - (move == 1)
            oy = y + (move == 2) - (move == 3)
            if ox < 0 or oy < 0 or ox >= nx or oy >= ny or not free[ox, oy]:
                continue
            if following < cost[ox, oy]:
                cost[ox, oy] = following
                size = push_key(heap, size, (following << _CELL_BITS) | (ox * ny + oy))
