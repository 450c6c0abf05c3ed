"""Cost from every lattice cell of one agent to its goal set (kernels), the A* heuristic."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from mamo_planners.mapf.kernel import kernel

from mamo_planners.mapf.heap import pop_key, push_key

Int64Array = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

FAR = np.int64(1 << 60)
"""Cost of what cannot be reached or is forbidden."""

_CELL_BITS = 24


@kernel
def uniform_distance(free: BoolArray, goal: Int64Array, unit: int) -> Int64Array:
    """Cost (nx, ny) to the cheapest goal where each step costs ``unit``.

    ``goal`` (nx, ny): cost of ending at a cell, ``FAR`` where that is not allowed. Steps cost the
    same, so a queue is sorted by itself; goals of different costs join it from a sorted list.
    """
    nx, ny = free.shape
    cost = np.full(nx * ny, FAR)
    sources = np.flatnonzero(goal.ravel() < FAR)
    values = goal.ravel()[sources]
    if values.size > 0 and values.max() > values.min():
        sources = sources[np.argsort(values, kind="mergesort")]
    queue = np.empty(nx * ny, np.int64)
    head, tail, source = 0, 0, 0
    flat_goal = goal.ravel()
    flat_free = free.ravel()
    while head < tail or source < sources.size:
        take_source = head == tail or (
            source < sources.size and flat_goal[sources[source]] <= cost[queue[head]]
        )
        if take_source:
            cell = sources[source]
            source += 1
            if cost[cell] <= flat_goal[cell]:
                continue
            cost[cell] = flat_goal[cell]
        else:
            cell = queue[head]
            head += 1
        following = cost[cell] + unit
        x, y = cell // ny, cell % ny
        for move in range(4):
            ox = x + (move == 0) - (move == 1)
            oy = y + (move == 2) - (move == 3)
            if ox < 0 or oy < 0 or ox >= nx or oy >= ny:
                continue
            other = ox * ny + oy
            # A source not taken yet is worth its own cost: never queue it above that.
            if flat_free[other] and following < min(cost[other], flat_goal[other]):
                cost[other] = following
                queue[tail] = other
                tail += 1
    return cost.reshape(nx, ny)


@kernel
def weighted_distance(free: BoolArray, goal: Int64Array, step: Int64Array) -> Int64Array:
    """As ``uniform_distance``, where arriving at a cell costs ``step`` (nx, ny)."""
    nx, ny = free.shape
    cost = goal.copy().ravel()
    heap = np.empty(8 * nx * ny + 8, np.int64)
    size = 0
    flat_step = step.ravel()
    flat_free = free.ravel()
    for cell in range(nx * ny):
        if cost[cell] < FAR:
            size = push_key(heap, size, (cost[cell] << _CELL_BITS) | cell)
    while size > 0:
        key, size = pop_key(heap, size)
        cell = key & ((1 << _CELL_BITS) - 1)
        if key >> _CELL_BITS > cost[cell]:
            continue
        following = cost[cell] + flat_step[cell]
        x, y = cell // ny, cell % ny
        for move in range(4):
            ox = x + (move == 0) - (move == 1)
            oy = y + (move == 2) - (move == 3)
            if ox < 0 or oy < 0 or ox >= nx or oy >= ny:
                continue
            other = ox * ny + oy
            if flat_free[other] and following < cost[other]:
                cost[other] = following
                size = push_key(heap, size, (following << _CELL_BITS) | other)
    return cost.reshape(nx, ny)
