"""The search of SPAMP (thesis, Algorithm 3): guided by subgoals to a motion that may push."""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mamo_core.types.geometry import Array
from mamo_core.types.solution import Plan
from mamo_planners.reaching.explored import Explored
from mamo_planners.reaching.lattice import Cell
from mamo_planners.reaching.primitive import Primitive
from mamo_planners.reaching.queues import Queues
from mamo_planners.reaching.soft_duplicates import inflated

if TYPE_CHECKING:
    from mamo_planners.reaching.spamp import Run


@dataclass(frozen=True, eq=False)
class Subgoal:
    """A primitive and the cell it begins in; ``valid``: Phase 2 valid (Definition 2)."""

    cell: Cell
    primitive: Primitive
    valid: bool


class SubgoalSearch:
    """Algorithm 3 under some subgoals."""

    def __init__(self, run: Run, subgoals: list[Subgoal], simulate_from: float) -> None:
        self._run, self._subgoals, self._simulate_from = run, subgoals, simulate_from
        self._valid = [subgoal for subgoal in subgoals if subgoal.valid]
        options = run.options
        self._queues = Queues(1 + len(subgoals), options.w1, options.w2)
        self._explored: Explored[Cell] = Explored()
        self._put_off: set[int] = set()
        self._waiting: list[tuple[float, int, Primitive]] = []

    def solve(self, expansions: int) -> Plan | None:
        """A verified plan; None when all is expanded or a limit is reached."""
        run = self._run
        self._insert([run.lattice.start], np.array([run.start]), -1)
        for _ in range(expansions):
            if run.budget.exhausted:
                return None
            plan = self._simulate_waiting()
            if plan is not None:
                return plan
            popped = self._queues.pop()
            if popped is None:
                if not self._waiting:
                    return None
                self._simulate_from = 0.0
                continue
            before = run.work.seconds
            plan = self._expand(*popped)
            self._queues.spend(popped[1], run.work.seconds - before)
            if plan is not None:
                return plan
        return None

    def _expand(self, state: int, queue: int) -> Plan | None:
        run = self._run
        run.work.expanded()
        run.statistics.counts["expansions"] += 1
        if state not in self._put_off:
            plan = self._to_subgoal(state)
            if plan is not None:
                return plan
            self._successors(state)
        q = self._explored.configurations[state]
        if not run.primitives.begins_at(q):
            return None
        if self._like_a_failure(state, q):
            put_off = inflated(self._heuristics(q)[queue])
            self._queues.push_into(queue, state, self._explored.costs[state], put_off)
            return None
        primitive = run.primitives.to_goal(q, run.rng)
        if primitive is None:
            return None
        if not primitive.interacts:
            return run.planned(self._explored.way(state), primitive)
        self._wait(state, primitive, self._heuristics(q)[0])
        return self._simulate_waiting()

    def _like_a_failure(self, state: int, q: Array) -> bool:
        """Whether a state (at ``q``) is a soft duplicate and has to be put off, once."""
        if state in self._put_off or not self._run.duplicates.near(q):
            return False
        self._run.statistics.counts["soft_duplicates"] += 1
        self._put_off.add(state)
        return True

    def _wait(self, state: int, primitive: Primitive, heuristic: float) -> None:
        key = self._explored.costs[state] + self._run.options.w1 * heuristic
        heapq.heappush(self._waiting, (key, state, primitive))

    def _to_subgoal(self, state: int) -> Plan | None:
        """Line 8 of Algorithm 3, or the straight motion to a valid subgoal."""
        run, q = self._run, self._explored.configurations[state]
        for subgoal in list(self._valid):
            there = self._explored.keys[state] == subgoal.cell
            start = subgoal.primitive.start
            if not there and run.options.snap:
                there = bool(run.scenery.everything.edges_free(q[None, :], start[None, :])[0])
            if there:
                plan = run.planned(self._explored.way(state), subgoal.primitive)
                if plan is not None:
                    return plan
                self._valid.remove(subgoal)
        return None

    def _simulate_waiting(self) -> Plan | None:
        """The best primitive of those that wait, once simulations are allowed."""
        run = self._run
        if not self._waiting or run.work.seconds < self._simulate_from:
            return None
        _, state, primitive = heapq.heappop(self._waiting)
        if self._like_a_failure(state, primitive.start):
            self._wait(state, primitive, inflated(self._heuristics(primitive.start)[0]))
            return None
        return run.planned(self._explored.way(state), primitive) if run.valid(primitive) else None

    def _successors(self, state: int) -> None:
        run = self._run
        cells = [
            c for c in run.lattice.successors(self._explored.keys[state]) if c not in self._explored
        ]
        if not cells:
            return
        ends = np.array([run.lattice.configuration(cell) for cell in cells])
        starts = np.repeat(self._explored.configurations[state][None, :], len(cells), axis=0)
        free = run.scenery.everything.edges_free(starts, ends)
        self._insert([c for c, ok in zip(cells, free, strict=True) if ok], ends[free], state)

    def _insert(self, cells: list[Cell], configurations: Array, parent: int) -> None:
        for cell, q in zip(cells, configurations, strict=True):
            number = self._explored.add(cell, q, parent)
            self._queues.push(number, self._explored.costs[number], self._heuristics(q))

    def _heuristics(self, q: Array) -> list[float]:
        """Primitives still to go: around obstacles for the tool, and straight to each subgoal."""
        run = self._run
        anchor = run.scenery.primitives_to_go(run.kinematics.forward(q)[:3, 3])
        step = float(run.lattice.steps.max())
        away = [float(np.linalg.norm(q - s.primitive.start)) / step for s in self._subgoals]
        return [anchor, *away]
