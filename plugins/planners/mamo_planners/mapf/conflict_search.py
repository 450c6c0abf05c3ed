"""Conflict-based search (Sharon et al., AIJ 2015), exact or within a factor (ECBS).

With ``weight`` 1 the nodes of the constraint tree are taken by cost and the answer is optimal;
above 1 any node within ``weight`` of the least lower bound may be taken, the one with the fewest
conflicts first (Barer et al., SoCS 2014). Conflicts are split soundly (``constraints``): every
solution of a node is a solution of one of its children, so the bound is one.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass, field, replace

import numpy as np

from mamo_planners.mapf.conflicts import (
    FIRST,
    MEET_AGAIN,
    PARTED,
    SECOND,
    WHAT,
    WHEN,
    find_conflicts,
    split_box,
)
from mamo_planners.mapf.constraints import FOREVER, NONE, NOTPARKED, RECT, REGION, constraint
from mamo_planners.mapf.distance import Int64Array
from mamo_planners.mapf.low_level import Others
from mamo_planners.mapf.model import Model
from mamo_planners.mapf.single import Plan, SinglePlanner, WorkOutError, no_others, with_path
from mamo_planners.mapf.tables import APART, CLOSEST, Int32Array

BOX_SHARE = 0.25
"""Share of the slack that a split's box takes (0.25 measured best)."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a search found: ``paths`` in lattice steps, or None; ``cost`` and ``bound`` in units.

    ``exhausted``: there is no solution at all. ``bound``: no solution costs less.
    """

    paths: tuple[Int32Array, ...] | None
    cost: int
    bound: int
    exhausted: bool
    nodes: int


@dataclass(frozen=True, eq=False)
class _Node:
    plans: tuple[Plan, ...]
    rows: tuple[Int32Array, ...]
    together: Int32Array
    others: Others
    bound: int
    conflicts: Int64Array = field(default_factory=lambda: np.zeros((0, 5), dtype=np.int64))

    @property
    def cost(self) -> int:
        return sum(plan.cost for plan in self.plans)


class ConflictSearch:
    """One search of the constraint tree.

    ``weight``: 1 for optimal. ``nodes``: limit of tree nodes expanded. ``candidates``: conflicts
    tried at each node before the one whose children cost most is kept (strong branching).
    """

    def __init__(
        self,
        model: Model,
        planner: SinglePlanner,
        weight: float,
        nodes: int,
        candidates: int,
        flexible: bool = False,
    ) -> None:
        self._model = model
        self._planner = planner
        self._weight = weight
        self._limit = nodes
        self._candidates = candidates
        self._flexible = flexible
        self._open = _Open(weight)
        self._expanded = 0

    def run(self) -> Outcome:
        """Searches until solved, exhausted or out of work; the bound is right in each case."""
        try:
            root = self._root()
            if root is None:
                return Outcome(None, 0, 0, True, 0)
            self._open.push(root)
            return self._search()
        except WorkOutError:
            return self._stopped(None, False)

    def _search(self) -> Outcome:
        while True:
            node = self._open.pop()
            if node is None:
                return self._stopped(None, True)
            if node.cost > self._weight * self._open.bound:
                self._open.push(self._tightened(node))
            elif len(node.conflicts) == 0 or self._expanded >= self._limit:
                return self._stopped(node if len(node.conflicts) == 0 else None, False)
            else:
                self._expanded += 1
                for child in self._children(node):
                    self._open.push(child)

    def _stopped(self, node: _Node | None, exhausted: bool) -> Outcome:
        paths = tuple(plan.path for plan in node.plans) if node else None
        cost = node.cost if node else 0
        return Outcome(paths, cost, self._open.bound, exhausted, self._expanded)

    def _root(self) -> _Node | None:
        n = self._model.count
        others = no_others(n)
        plans = []
        for agent in range(n):
            plan = self._planner.plan(agent, NONE, others, self._weight)
            if plan is None:
                return None
            plans.append(plan)
            others = with_path(others, agent, plan.path)
        together = np.zeros((n, n), dtype=np.int32)
        bound = sum(plan.bound for plan in plans)
        return self._checked(_Node(tuple(plans), (NONE,) * n, together, others, bound))

    def _checked(self, node: _Node) -> _Node:
        found = find_conflicts(
            node.others.paths, node.others.lengths, self._model.tables, node.together
        )
        return replace(node, conflicts=found)

    def _children(self, node: _Node) -> list[_Node]:
        """The children of the conflict that raises the cost most, of a few tried."""
        best: tuple[tuple[float, float], list[_Node]] | None = None
        order = np.argsort(-node.conflicts[:, 3], kind="stable")[: self._candidates]
        for conflict in node.conflicts[order]:
            children = self._split(node, conflict)
            rises = sorted(child.bound - node.bound for child in children)
            if len(children) < 2:
                return children  # one side is impossible: nothing can be better
            score = float(rises[0]), float(rises[1])
            if best is None or score > best[0]:
                best = score, children
            if rises[0] > 0:
                break  # every child costs more: as good as a split can be
        assert best is not None
        return best[1]

    def _split(self, node: _Node, conflict: Int64Array) -> list[_Node]:
        i, j, t, what = (int(conflict[k]) for k in (FIRST, SECOND, WHEN, WHAT))
        resting = [t >= len(node.plans[agent].path) - 1 for agent in (i, j)]
        if resting[0] and not resting[1]:
            i, j = j, i
        parked = any(resting)
        xi, yi = _at(node.plans[i].path, t)
        xj, yj = _at(node.plans[j].path, t)
        if what == PARTED:
            pairs = [
                (i, constraint(RECT, i, CLOSEST, (xi, yi, xi, yi), t, t)),
                (j, constraint(RECT, j, CLOSEST, (xj, yj, xj, yj), t, t)),
            ]
        else:
            table = APART if what == MEET_AGAIN else CLOSEST
            box = split_box(self._model.tables, table, i, j, xi, yi, xj, yj, BOX_SHARE)
            pairs = [
                (i, constraint(REGION, j, table, box, t, FOREVER if parked else t)),
                (j, constraint(NOTPARKED if parked else RECT, j, table, box, t, t)),
            ]
        children = [self._child(node, agent, row) for agent, row in pairs]
        if what == MEET_AGAIN:
            # Or the two have not parted by then: a third way out.
            together = node.together.copy()
            together[min(i, j), max(i, j)] = max(t, together[min(i, j), max(i, j)])
            children.append(self._checked(replace(node, together=together)))
        return [child for child in children if child is not None]

    def _child(self, node: _Node, agent: int, row: Int32Array) -> _Node | None:
        rows = np.concatenate([node.rows[agent], row])
        plan = self._replan(node, agent, rows)
        if plan is None:
            return None
        plans = (*node.plans[:agent], plan, *node.plans[agent + 1 :])
        return self._checked(
            _Node(
                plans,
                (*node.rows[:agent], rows, *node.rows[agent + 1 :]),
                node.together,
                with_path(node.others, agent, plan.path),
                max(node.bound, sum(p.bound for p in plans)),
            )
        )

    def _replan(self, node: _Node, agent: int, rows: Int32Array) -> Plan | None:
        """A plan for one agent of the node that keeps all together within the weight.

        Flexible: it may use what the others leave (Chan et al., AAAI 2022); each agent by itself
        otherwise.
        """
        if self._weight <= 1.0 or not self._flexible:
            return self._planner.plan(agent, rows, node.others, self._weight)
        allowance = int(self._weight * node.bound) - (node.cost - node.plans[agent].cost)
        return self._planner.plan(agent, rows, node.others, 1.0, max(allowance, 0))

    def _tightened(self, node: _Node) -> _Node:
        """The node with every plan within the weight of its own bound, so the node is too."""
        plans, others = list(node.plans), node.others
        for agent, rows in enumerate(node.rows):
            if plans[agent].cost > self._weight * plans[agent].bound:
                plan = self._planner.plan(agent, rows, others, self._weight)
                assert plan is not None  # the same search found one before
                plans[agent] = plan
                others = with_path(others, agent, plan.path)
        bound = max(node.bound, sum(plan.bound for plan in plans))
        return self._checked(replace(node, plans=tuple(plans), others=others, bound=bound))


class _Open:
    """Tree nodes by bound, and by conflicts those whose cost is within ``weight`` of the least."""

    def __init__(self, weight: float) -> None:
        self.bound = 0
        self._weight = weight
        self._made = 0
        self._by_bound: list[tuple[int, int]] = []
        self._by_cost: list[tuple[int, int]] = []
        self._focal: list[tuple[int, int, int]] = []
        self._nodes: dict[int, _Node] = {}

    def push(self, node: _Node) -> None:
        self._made += 1
        # Later nodes first among equals: they are nearer to a solution.
        name = -self._made
        self._nodes[name] = node
        heapq.heappush(self._by_bound, (node.bound, name))
        heapq.heappush(self._by_cost, (node.cost, name))

    def pop(self) -> _Node | None:
        """The next node, or None; ``bound`` is then the least of all that were left."""
        while self._by_bound and self._by_bound[0][1] not in self._nodes:
            heapq.heappop(self._by_bound)
        if not self._by_bound:
            return None
        self.bound = max(self.bound, self._by_bound[0][0])
        limit = int(self._weight * self.bound)
        while self._by_cost and self._by_cost[0][0] <= limit:
            cost, name = heapq.heappop(self._by_cost)
            if name in self._nodes:
                heapq.heappush(self._focal, (len(self._nodes[name].conflicts), cost, name))
        # Where the flexible slack was overdrawn, no node may be within the limit.
        name = heapq.heappop(self._focal)[2] if self._focal else self._by_bound[0][1]
        return self._nodes.pop(name)


def _at(path: Int32Array, t: int) -> tuple[int, int]:
    x, y = path[min(t, len(path) - 1)]
    return int(x), int(y)
