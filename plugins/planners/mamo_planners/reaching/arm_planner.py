"""Multi-heuristic A* over joint primitives as a motion planner of the arm (thesis 3.4, 4.3)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mamo_core.interfaces.arm_planner import ArmPlan, ArmPlanner, ArmPlanStatus, free_goals
from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, BoolArray
from mamo_core.types.problem import Problem
from mamo_planners.reaching.explored import Explored
from mamo_planners.reaching.lattice import Cell, Lattice
from mamo_planners.reaching.options import ArmLatticeOptions
from mamo_planners.reaching.queues import Queues
from mamo_planners.reaching.scenery import field_to, primitives_to_go
from mamo_planners.reaching.shortcuts import straightened

Distances = Callable[[Array], float]
"""Primitives still to go from a position (3,) of the tool."""


class MultiHeuristicAStar(ArmPlanner):
    """One list for the tool's way around fixtures, one for the straight way to each goal.

    ``checks`` of its plans, and ``max_checks``, count edges: primitives, and the straight motions
    from every expanded state to the goals.
    """

    def __init__(
        self, problem: Problem, arm: ArmModel, kinematics: Kinematics, options: ArmLatticeOptions
    ) -> None:
        self._problem, self._arm, self._kinematics = problem, arm, kinematics
        self._options = options

    def plan(
        self,
        start: Array,
        goals: Array,
        world: CollisionWorld,
        rng: np.random.Generator,
        *,
        max_checks: int | None = None,
    ) -> ArmPlan:
        free = free_goals(start, goals, world)
        if isinstance(free, ArmPlan):
            return free
        limit = self._options.max_checks if max_checks is None else max_checks
        search = _Query(self, start, goals[free], world)
        found = search.solve(limit)
        if found is None:
            return ArmPlan(ArmPlanStatus.EXHAUSTED, None, -1, search.checks)
        path, goal = found
        short = straightened(path, world)
        return ArmPlan(ArmPlanStatus.SOLVED, short, int(free[goal]), search.checks)

    def lattice(self, start: Array) -> Lattice:
        """Configurations whole primitives away from ``start`` (dof,)."""
        options = self._options
        return Lattice(self._arm, start, options.large_step_deg, options.small_step_deg)

    def queues(self, count: int) -> Queues:
        """So many open lists."""
        return Queues(count, self._options.w1, self._options.w2)

    def tool(self, q: Array) -> Array:
        """Position (3,) of the tool, world."""
        return self._kinematics.forward(q)[:3, 3]

    def distances(self, start: Array, goals: Array) -> Distances:
        """Heuristics for one query."""
        points = np.array([self.tool(q) for q in goals])
        solids = [(fixture.shape, fixture.pose) for fixture in self._problem.scene.fixtures]
        field = field_to(self._problem, self.tool(start), points, solids, self._options)
        return lambda point: primitives_to_go(field, point)


class _Query:
    """One call of ``plan`` with free start and goals (m, dof)."""

    def __init__(
        self, planner: MultiHeuristicAStar, start: Array, goals: Array, world: CollisionWorld
    ) -> None:
        self._planner, self._goals, self._world = planner, goals, world
        self._lattice = planner.lattice(start)
        self._queues = planner.queues(1 + len(goals))
        self._to_go = planner.distances(start, goals)
        self._explored: Explored[Cell] = Explored()
        self.checks = 1 + len(goals)
        self._add(self._lattice.start, start, -1)

    def solve(self, limit: int) -> tuple[Array, int] | None:
        """A path (k, dof) and the number of its goal."""
        while self.checks < limit:
            popped = self._queues.pop()
            if popped is None:
                return None
            state, queue = popped
            self._queues.spend(queue, 1.0)
            q = self._explored.configurations[state]
            reached = np.flatnonzero(self._edges_free(q, self._goals))
            if reached.size:
                way = self._explored.way(state)
                return np.vstack([way, self._goals[reached[0]]]), int(reached[0])
            self._expand(state, q)
        return None

    def _expand(self, state: int, q: Array) -> None:
        cells = [
            cell
            for cell in self._lattice.successors(self._explored.keys[state])
            if cell not in self._explored
        ]
        if cells:
            ends = np.array([self._lattice.configuration(cell) for cell in cells])
            for k in np.flatnonzero(self._edges_free(q, ends)):
                self._add(cells[k], ends[k], state)

    def _edges_free(self, q: Array, ends: Array) -> BoolArray:
        self.checks += len(ends)
        return self._world.edges_free(np.repeat(q[None, :], len(ends), axis=0), ends)

    def _add(self, cell: Cell, q: Array, parent: int) -> None:
        number = self._explored.add(cell, q, parent)
        step = float(self._lattice.steps.max())
        away = np.linalg.norm(self._goals - q, axis=1) / step
        anchor = self._to_go(self._planner.tool(q))
        self._queues.push(number, self._explored.costs[number], [anchor, *away.tolist()])
