"""K3, our own KPIECE: simulates only what touches something, and never what must not be touched."""

from __future__ import annotations

import numpy as np

from mamo_core.types.geometry import Array
from mamo_core.types.solution import Plan
from mamo_planners.baselines.sampling.cells import Cells
from mamo_planners.baselines.sampling.growth import Growth, Node, strided
from mamo_planners.baselines.sampling.options import K3Options
from mamo_planners.reaching.goals import Goal


def k3(growth: Growth, root: Node, options: K3Options) -> Plan | None:
    """A verified plan, or None once the growth is over or the actions are used up."""
    tree = _Tree(growth, options)
    tree.add(root)
    counts = growth.statistics.counts
    while not growth.over and counts["actions"] < options.actions:
        counts["actions"] += 1
        if growth.rng.random() >= options.goal_bias:
            tree.grow()
            continue
        plan = tree.grow_to_goal()
        if plan is not None:
            return plan
    return None


class _Tree:
    """The nodes, in cells by tool position and in a list for what is near a goal."""

    def __init__(self, growth: Growth, options: K3Options) -> None:
        self._growth, self._options = growth, options
        self._fixed = growth.goals.without_movables()
        self._cells = Cells(options.cell, options.levels, options.border)
        self._nodes: list[Node] = []
        self._ranks: list[float] = []

    def add(self, node: Node) -> bool:
        """Whether the node is where none was."""
        q = node.configuration
        distance = self._growth.to_goal(q)
        self._nodes.append(node)
        self._ranks.append(distance)
        return self._cells.add(node, self._growth.tool(q), distance)

    def grow(self) -> None:
        """One action towards a random configuration, from the most important cell."""
        growth, options = self._growth, self._options
        chain, node = self._cells.select(growth.rng)
        target = growth.rng.uniform(growth.low, growth.high)
        count = int(growth.rng.integers(1, options.strides + 1))
        places = strided(node.configuration, target, options.stride)[:count]
        new, _ = self._led(node, places)
        self._cells.reward(chain, progress=new)

    def grow_to_goal(self) -> Plan | None:
        """One action to a goal, from the node nearest to one that was not tried as often."""
        growth = self._growth
        index = int(np.argmin(self._ranks))
        self._ranks[index] = 2.0 * self._ranks[index] + self._options.cell
        goal = growth.goals.drawn(growth.rng)
        node = self._nodes[index]
        places = strided(node.configuration, goal.configuration, self._options.stride)
        _, last = self._led(node, places)
        return self._done(last, goal)

    def _done(self, last: Node, goal: Goal) -> Plan | None:
        there = np.abs(last.configuration - goal.configuration).max() < 1e-9
        return self._growth.finished(last, goal) if there else None

    def _led(self, node: Node, places: Array) -> tuple[bool, Node]:
        """The arm goes from place (k, dof) to place as far as it may; every place is a node.

        Whether a new cell was reached, and the last node.
        """
        new = False
        for q in places[: self._unblocked(node.configuration, places)]:
            child = self._moved(node, q)
            if child is None or self._growth.over:
                break
            node = child
            new |= self.add(node)
        return new, node

    def _unblocked(self, start: Array, places: Array) -> int:
        """Phase 1 (thesis 3.3.2): how many places come before a fixture or an immovable."""
        if not len(places):
            return 0
        free = self._fixed.edges_free(np.vstack([start, places[:-1]]), places)
        return len(places) if free.all() else int(np.argmin(free))

    def _moved(self, node: Node, q: Array) -> Node | None:
        """Simulated only if something is in the way."""
        growth = self._growth
        everything = growth.goals.with_everything(node.stand.state)
        if everything.edges_free(node.configuration[None], q[None])[0]:
            return growth.went(node, q)
        return growth.pushed(node, q)
