"""The path of one agent under constraints: focal A* in space and time (kernel).

States are (cell, time) until the constraints stop changing, cells alone after that. Coming to
rest is an entry of its own, made only by a move (or by never moving), so that "not at rest here
by t" is exact. Nodes are ordered by cost within ``weight`` of the least bound and, among those,
by the number of other agents' paths they run into (Barer et al., SoCS 2014).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mamo_planners.mapf.constraints import FOREVER, Forbidden, mark_forbidden
from mamo_planners.mapf.distance import FAR, BoolArray, Int64Array
from mamo_planners.mapf.heap import pop_key, push_key
from mamo_planners.mapf.kernel import kernel
from mamo_planners.mapf.model import AgentMap
from mamo_planners.mapf.tables import CLOSEST, Int16Array, Int32Array, PairTables, overlap

FOUND, NO_PATH, OUT_OF_WORK, OUT_OF_ROOM = 0, 1, 2, 3

ID_BITS, HITS_BITS, COST_BITS = 22, 11, 30
MAX_NODES = (1 << ID_BITS) - 1
_MAX_HITS = (1 << HITS_BITS) - 1
_MAX_COST = (1 << COST_BITS) - 1
_ENTRIES_A_STEP = 10
_LOWER = 0xFFFFFFFF

CELL, TIME, PARENT, COST, BOUND, HITS, STATE = range(7)
"""Columns of the node table."""
LIVE, DEAD, RESTING = 0, 1, 2
"""Node states: to be expanded; expanded or replaced; at rest for good."""
N_NODES, N_FOCAL, N_WAITING, N_EVERY, FLOOR, LIMIT = range(6)
"""Counters: sizes, the least bound so far, the bound that is good enough."""


class Others(NamedTuple):
    """Paths (n, T, 2) in lattice steps, the first ``lengths`` (n,) rows used; 0: not known yet.

    ``hard`` (n,): agents that must be avoided; others only should be.
    """

    paths: Int32Array
    lengths: Int64Array
    hard: BoolArray


class Workspace(NamedTuple):
    """Room for one search: ``nodes`` (m, 7), ``heaps`` (3, m), ``counters`` (6,).

    ``best`` (2 layers, cells): the node that reached a state, and below it the one that rests
    there; entries count only with the search's own ``stamp`` (1,) in their upper half.
    """

    nodes: Int64Array
    heaps: Int64Array
    counters: Int64Array
    best: Int64Array
    stamp: Int64Array
    forbidden: Forbidden


class Query(NamedTuple):
    """What is asked; costs in units.

    ``stay``: cost of never moving. ``horizon``: time from which nothing changes. A path is good
    enough within ``weight`` times the least bound, or within ``allowance``. ``work``: expansions.
    """

    agent: int
    stay: int
    wait: int
    horizon: int
    weight: float
    allowance: int
    work: int


@kernel
def _hits(
    agent: int,
    x: int,
    y: int,
    t: int,
    until: int,
    paths: Int32Array,
    lengths: Int64Array,
    hard: BoolArray,
    low: Int16Array,
    high: Int16Array,
    first: Int32Array,
) -> int:
    """Other paths overlapped at (x, y) from t to ``until``, a step each; -1 if one is hard."""
    hits = 0
    for j in range(lengths.shape[0]):
        if j == agent:
            continue
        for s in range(min(t, lengths[j] - 1), min(until, lengths[j] - 1) + 1):
            if s < 0:
                continue  # this path is not known yet
            dx, dy = x - paths[j, s, 0], y - paths[j, s, 1]
            if overlap(low, high, first, CLOSEST, agent, j, dx, dy):
                if hard[j]:
                    return -1
                hits += 1
    return hits


@kernel
def _cheap_key(cost: int, hits: int, node: int) -> int:
    return (cost << (HITS_BITS + ID_BITS)) | (min(hits, _MAX_HITS) << ID_BITS) | (MAX_NODES - node)


@kernel
def _calm_key(cost: int, hits: int, node: int) -> int:
    return (min(hits, _MAX_HITS) << (COST_BITS + ID_BITS)) | (cost << ID_BITS) | (MAX_NODES - node)


@kernel
def _queue(
    exact: bool,
    node: int,
    bound: int,
    hits: int,
    counters: Int64Array,
    focal: Int64Array,
    waiting: Int64Array,
    every: Int64Array,
) -> None:
    if exact:
        counters[N_FOCAL] = push_key(focal, counters[N_FOCAL], _cheap_key(bound, hits, node))
        return
    key = _cheap_key(bound, 0, node)
    counters[N_EVERY] = push_key(every, counters[N_EVERY], key)
    if bound <= counters[LIMIT]:
        key = _calm_key(bound, hits, node)
        counters[N_FOCAL] = push_key(focal, counters[N_FOCAL], key)
    else:
        counters[N_WAITING] = push_key(waiting, counters[N_WAITING], key)


@kernel
def _raise_limit(
    weight: float,
    allowance: int,
    nodes: Int64Array,
    counters: Int64Array,
    focal: Int64Array,
    waiting: Int64Array,
    every: Int64Array,
) -> None:
    """Brings the least bound up to date and queues what is good enough now."""
    while counters[N_EVERY] > 0:
        node = MAX_NODES - (every[0] & MAX_NODES)
        if nodes[node, STATE] != DEAD:
            counters[FLOOR] = max(counters[FLOOR], nodes[node, BOUND])
            break
        _, counters[N_EVERY] = pop_key(every, counters[N_EVERY])
    counters[LIMIT] = max(np.int64(weight * counters[FLOOR]), np.int64(allowance))
    while counters[N_WAITING] > 0 and waiting[0] >> (HITS_BITS + ID_BITS) <= counters[LIMIT]:
        key, counters[N_WAITING] = pop_key(waiting, counters[N_WAITING])
        node = MAX_NODES - (key & MAX_NODES)
        if nodes[node, STATE] != DEAD:
            key = _calm_key(nodes[node, BOUND], nodes[node, HITS], node)
            counters[N_FOCAL] = push_key(focal, counters[N_FOCAL], key)


@kernel
def _worse(nodes: Int64Array, old: int, cost: int, hits: int) -> bool:
    """Whether reaching a state at ``cost`` and ``hits`` adds nothing to node ``old``."""
    if old < 0 or nodes[old, COST] > cost:
        return False
    same = nodes[old, COST] == cost
    return not same or nodes[old, STATE] == DEAD or nodes[old, HITS] <= hits


@kernel
def plan(
    query: Query,
    grid: AgentMap,
    rows: Int32Array,
    others: Others,
    tables: PairTables,
    work: Workspace,
) -> tuple[int, int, int, int, int]:
    """Searches; returns (outcome, final node, cost, lower bound, expansions).

    One long function on plain local arrays: reaching into tuples, or passing them on, counts
    references with atomic operations, which took most of the time when it was split up.
    """
    agent, stay, wait, horizon, weight, allowance, allowed = query
    grid_first, free, goal, step, distance = grid
    paths, lengths, hard = others
    low, high, first, _ = tables
    nodes, heaps, counters, best, stamps, forbidden = work
    at, since, until = forbidden
    focal, waiting, every = heaps[0], heaps[1], heaps[2]

    exact = weight <= 1.0 and allowance <= 0
    room = min(nodes.shape[0], MAX_NODES) - _ENTRIES_A_STEP
    width, depth = free.shape
    expansions = 0
    stamps[0] += 1
    stamp = stamps[0]
    mark_forbidden(rows, agent, grid_first, free, tables, stamp, forbidden)
    counters[:] = 0
    counters[LIMIT] = -1
    x, y = -grid_first[0], -grid_first[1]
    start = x * depth + y
    # The start is a node; never moving is an entry at rest.
    for kind in range(2):
        bound = distance[x, y] if kind == 0 else np.int64(stay)
        hits = 0
        if kind == 1 and bound <= _MAX_COST:
            hits = _hits(agent, 0, 0, 1, FOREVER, paths, lengths, hard, low, high, first)
        if bound > _MAX_COST or hits < 0 or (kind == 1 and until[start] >= 0):
            continue
        node = counters[N_NODES]
        counters[N_NODES] += 1
        nodes[node, CELL], nodes[node, TIME], nodes[node, PARENT] = start, 0, -1
        nodes[node, COST], nodes[node, BOUND] = (0 if kind == 0 else bound), bound
        nodes[node, HITS], nodes[node, STATE] = hits, (LIVE if kind == 0 else RESTING)
        best[0 if kind == 0 else horizon + 1, start] = (stamp << 32) | node
        _queue(exact, node, bound, hits, counters, focal, waiting, every)

    while True:
        if not exact:
            _raise_limit(weight, allowance, nodes, counters, focal, waiting, every)
        if counters[N_FOCAL] == 0:
            return NO_PATH, -1, 0, 0, expansions
        key, counters[N_FOCAL] = pop_key(focal, counters[N_FOCAL])
        parent = MAX_NODES - (key & MAX_NODES)
        if nodes[parent, STATE] == DEAD:
            continue
        if exact:
            counters[FLOOR] = nodes[parent, BOUND]
        if nodes[parent, STATE] == RESTING:
            return FOUND, parent, nodes[parent, COST], counters[FLOOR], expansions
        if expansions >= allowed:
            return OUT_OF_WORK, -1, 0, counters[FLOOR], expansions
        if counters[N_NODES] >= room:
            return OUT_OF_ROOM, -1, 0, counters[FLOOR], expansions
        expansions += 1
        nodes[parent, STATE] = DEAD

        cell, t = nodes[parent, CELL], nodes[parent, TIME] + 1
        cost_before, hits_before = nodes[parent, COST], nodes[parent, HITS]
        layer = min(t, horizon)
        # Waiting is of no use once nothing changes any more.
        for move in range(5 if t <= horizon else 4):
            x = cell // depth + (move == 0) - (move == 1)
            y = cell % depth + (move == 2) - (move == 3)
            if x < 0 or y < 0 or x >= width or y >= depth or distance[x, y] >= FAR:
                continue
            other = x * depth + y
            if since[other] <= t or at[layer, other] == stamp:
                continue
            cost = cost_before + (wait if move == 4 else step[x, y])
            bound = max(cost + distance[x, y], nodes[parent, BOUND])
            total = cost + goal[x, y]
            known = best[layer, other]
            old = known & _LOWER if known >> 32 == stamp else np.int64(-1)
            known = best[horizon + 1 + layer, other]
            old_rest = known & _LOWER if known >> 32 == stamp else np.int64(-1)
            passing = bound <= _MAX_COST and not _worse(nodes, old, cost, hits_before)
            resting = move != 4 and total <= _MAX_COST and t > until[other]
            resting = resting and not _worse(nodes, old_rest, total, hits_before)
            if not passing and not resting:
                continue
            kx, ky = x + grid_first[0], y + grid_first[1]
            hits = _hits(agent, kx, ky, t, t, paths, lengths, hard, low, high, first)
            if hits < 0:
                continue
            hits += hits_before
            for kind in range(2):
                if kind == 0 and (not passing or _worse(nodes, old, cost, hits)):
                    continue
                if kind == 1:
                    if not resting:
                        continue
                    later = _hits(
                        agent, kx, ky, t + 1, FOREVER, paths, lengths, hard, low, high, first
                    )
                    hits += later
                    if later < 0 or _worse(nodes, old_rest, total, hits):
                        continue
                    old, cost, bound = old_rest, total, total
                node = counters[N_NODES]
                counters[N_NODES] += 1
                if old >= 0:
                    nodes[old, STATE] = DEAD
                nodes[node, CELL], nodes[node, TIME], nodes[node, PARENT] = other, t, parent
                nodes[node, COST], nodes[node, BOUND], nodes[node, HITS] = cost, bound, hits
                nodes[node, STATE] = LIVE if kind == 0 else RESTING
                best[layer + kind * (horizon + 1), other] = (stamp << 32) | node
                _queue(exact, node, bound, hits, counters, focal, waiting, every)


@kernel
def struck(agent: int, others: Others, tables: PairTables) -> bool:
    """Whether the agent, if it never moves, is run into by one that must be avoided."""
    paths, lengths, hard = others
    low, high, first, _ = tables
    return _hits(agent, 0, 0, 1, FOREVER, paths, lengths, hard, low, high, first) < 0


@kernel
def trace(node: int, nodes: Int64Array, grid: AgentMap) -> Int32Array:
    """The path (T + 1, 2) to ``node`` in lattice steps from the start."""
    ny = grid.free.shape[1]
    length = 0
    back = node
    while back >= 0:
        length += 1
        back = nodes[back, PARENT]
    path = np.empty((length, 2), np.int32)
    for k in range(length - 1, -1, -1):
        path[k, 0] = nodes[node, CELL] // ny + grid.first[0]
        path[k, 1] = nodes[node, CELL] % ny + grid.first[1]
        node = nodes[node, PARENT]
    return path
