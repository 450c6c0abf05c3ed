"""SPAMP (thesis, Algorithms 2 and 3): only the last motion may push, and only it is simulated."""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np

from mamo_core.interfaces.search_strategy import ProgressCallback, SearchStrategy
from mamo_core.types.geometry import Array
from mamo_core.types.motion import MotionSegment
from mamo_core.types.solution import Budget, Plan, Solution, SolutionStatus, Statistics
from mamo_planners.reaching.amp import Primitive, Primitives
from mamo_planners.reaching.explored import Explored
from mamo_planners.reaching.goals import Goals
from mamo_planners.reaching.lattice import Cell, Lattice
from mamo_planners.reaching.motions import Motions
from mamo_planners.reaching.options import SpampOptions
from mamo_planners.reaching.queues import Queues
from mamo_planners.reaching.scenery import Scenery, look_at
from mamo_planners.reaching.shortcuts import straightened
from mamo_planners.reaching.stand import Executions, ReachingParts
from mamo_planners.reaching.work import Work

_INFLATION = 10.0


class Spamp(SearchStrategy):
    """Rounds of Algorithm 2, each with subgoals of its own, until a plan is verified."""

    def __init__(self, parts: ReachingParts, options: SpampOptions) -> None:
        self._parts, self._options = parts, options

    def solve(
        self, budget: Budget, rng: np.random.Generator, progress: ProgressCallback
    ) -> Solution:
        parts, statistics = self._parts, Statistics()
        with statistics.timed("goals"):
            goals = Goals(parts.problem, parts.arm, parts.kinematics, parts.collision, rng)
        if not goals.known:
            words = "no pre-grasp can be taken up even without movables"
            return Solution(SolutionStatus.BUDGET_EXHAUSTED, None, statistics, words)
        with statistics.timed("heuristic"):
            scenery = look_at(parts, goals, self._options)
        run = _Run(parts, self._options, scenery, statistics, budget, rng)
        for number in range(self._options.rounds):
            progress(f"round {number + 1}")
            statistics.counts["rounds"] += 1
            plan = run.round(number + 1)
            if plan is not None:
                return Solution(SolutionStatus.SOLVED, plan, statistics)
            if budget.exhausted:
                break
        why = "no plan within the budget" if budget.exhausted else "nothing is left to try"
        return Solution(SolutionStatus.BUDGET_EXHAUSTED, None, statistics, why)


@dataclass(frozen=True, eq=False)
class _Subgoal:
    """A primitive and the cell it begins in; ``valid``: Phase 2 valid (Definition 2)."""

    cell: Cell
    primitive: Primitive
    valid: bool


class _Run:
    """One call of ``solve``; ``failed`` primitives are remembered from round to round."""

    def __init__(
        self,
        parts: ReachingParts,
        options: SpampOptions,
        scenery: Scenery,
        statistics: Statistics,
        budget: Budget,
        rng: np.random.Generator,
    ) -> None:
        self.options, self.scenery, self.statistics = options, scenery, statistics
        self.kinematics, self.budget, self.rng = parts.kinematics, budget, rng
        self.arm_planner = parts.arm_planner
        self.start = parts.problem.initial.joint_positions
        self.lattice = Lattice(
            parts.arm, self.start, options.large_step_deg, options.small_step_deg
        )
        self.motions = Motions(parts.arm, parts.kinematics, options, scenery.goals.opening)
        self.executions = Executions(parts, statistics, budget)
        self.primitives = Primitives(
            parts.kinematics,
            scenery.goals,
            scenery.fixed,
            scenery.everything,
            scenery.field,
            options.delta,
        )
        self.work = Work()
        self.failed: list[Array] = []

    def round(self, number: int) -> Plan | None:
        """Algorithm 2: subgoals, then the search they guide."""
        began = self.work.seconds
        options = self.options
        wider = options.delta * (1.0 + options.growth * (number - 1))
        self.primitives.delta = min(wider, max(options.widest, options.delta))
        subgoals = self._subgoals(options.via if number > 1 else 0.0)
        plan = self._connected(subgoals) if options.connect else None
        if plan is not None:
            return plan
        any_valid = any(subgoal.valid for subgoal in subgoals)
        simulate_from = began + self.options.t_sim if any_valid else began
        return _Search(self, subgoals, simulate_from).solve(luby(number) * self.options.expansions)

    def valid(self, primitive: Primitive) -> bool:
        """Phase 2: simulate what may touch movables; what fails is remembered."""
        if not primitive.interacts:
            return True
        self.statistics.counts["simulated_primitives"] += 1
        steps = self.statistics.counts["steps"]
        valid = self.executions.alone(self.motions.sweep(primitive.path))
        self.work.simulated(self.statistics.counts["steps"] - steps)
        if not valid:
            self.failed.append(primitive.start)
        return valid

    def is_duplicate(self, q: Array) -> bool:
        """Whether a primitive that failed began within beta of ``q`` (dof,) (3.3.6)."""
        beta = self.options.beta
        if beta is None or not self.failed:
            return False
        return bool((np.linalg.norm(np.array(self.failed) - q, axis=1) < beta).any())

    def planned(self, way: Array, primitive: Primitive) -> Plan | None:
        """The plan that goes along ``way`` (k, dof) and ends with the primitive, if it holds."""
        opened = self.motions.opened(self.start)
        if not primitive.interacts:
            gone = self._gone(np.vstack([way, primitive.path]))
            return self._finished([opened, *gone], primitive)
        gone = self._gone(np.vstack([way, primitive.path[:1]]))
        return self._finished([opened, *gone, self.motions.sweep(primitive.path)], primitive)

    def _gone(self, way: Array) -> list[MotionSegment]:
        """The arm goes along ``way`` (k, dof), by short cuts; nothing if it is there already."""
        path = straightened(way, self.scenery.everything)
        return [self.motions.transit(path)] if np.ptp(path, axis=0).any() else []

    def _finished(self, segments: list[MotionSegment], primitive: Primitive) -> Plan | None:
        if primitive.goal.candidate is None:
            plan = self.executions.verified(tuple(segments))
        else:
            stand = self.executions.start(segments[0])
            for segment in segments[1:]:
                stand = self.executions.after(stand, segment) if stand is not None else None
            plan = (
                self.executions.finished(stand, primitive.goal, self.rng)
                if stand is not None
                else None
            )
        if plan is None:
            self.failed.append(primitive.start)
        return plan

    def _connected(self, subgoals: list[_Subgoal]) -> Plan | None:
        """The way to a valid subgoal that the arm planner finds; one that does not do is left."""
        left = [subgoal for subgoal in subgoals if subgoal.valid]
        while left:
            goals = np.array([subgoal.primitive.start for subgoal in left])
            with self.statistics.timed("arm_planning"):
                found = self.arm_planner.plan(self.start, goals, self.scenery.everything, self.rng)
            if found.path is None:
                return None
            subgoal = left.pop(found.goal)
            plan = self.planned(found.path, subgoal.primitive)
            if plan is not None:
                return plan
            subgoals.remove(subgoal)
        return None

    def _subgoals(self, via: float) -> list[_Subgoal]:
        """N of M primitives, valid ones first (GetValidSubgoals of Algorithm 2)."""
        options = self.options
        if not options.subgoals:
            return []
        drawn: list[_Subgoal] = []
        for primitive in self.primitives.drawn(self.rng, self._rounded, via):
            cell = self.lattice.nearest(primitive.start)
            valid = not primitive.interacts or (options.simulate_samples and self.valid(primitive))
            drawn.append(_Subgoal(cell, primitive, valid))
            if len(drawn) >= options.samples or self.budget.exhausted:
                break
        self.statistics.counts["drawn_primitives"] += len(drawn)
        drawn.sort(key=lambda subgoal: not subgoal.valid)
        return drawn[: options.subgoals]

    def _rounded(self, q: Array) -> Array:
        return self.lattice.configuration(self.lattice.nearest(q))


def luby(number: int) -> int:
    """The n-th term (from 1) of 1, 1, 2, 1, 1, 2, 4, …: how long to try before starting anew.

    No other sequence is much better where the time to success is unknown (Luby et al., 1993).
    """
    power = number.bit_length()
    if number == (1 << power) - 1:
        return 1 << (power - 1)
    return luby(number - (1 << (power - 1)) + 1)


class _Search:
    """Algorithm 3 under some subgoals."""

    def __init__(self, run: _Run, subgoals: list[_Subgoal], simulate_from: float) -> None:
        self._run, self._subgoals, self._simulate_from = run, subgoals, simulate_from
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
        if state not in self._put_off and run.is_duplicate(q):
            run.statistics.counts["soft_duplicates"] += 1
            self._put_off.add(state)
            # Also where a subgoal begins, to which the heuristic is 0.
            inflated = _INFLATION * max(self._heuristics(q)[queue], 1.0)
            self._queues.push_into(queue, state, self._explored.costs[state], inflated)
            return None
        primitive = run.primitives.to_goal(q, run.rng)
        if primitive is None:
            return None
        if not primitive.interacts:
            return run.planned(self._explored.way(state), primitive)
        key = self._explored.costs[state] + run.options.w1 * self._heuristics(q)[0]
        heapq.heappush(self._waiting, (key, state, primitive))
        return self._simulate_waiting()

    def _to_subgoal(self, state: int) -> Plan | None:
        """Line 8 of Algorithm 3, or the straight motion to a valid subgoal."""
        run, q = self._run, self._explored.configurations[state]
        for subgoal in [s for s in self._subgoals if s.valid]:
            there = self._explored.keys[state] == subgoal.cell
            start = subgoal.primitive.start
            if not there and run.options.snap:
                there = bool(run.scenery.everything.edges_free(q[None, :], start[None, :])[0])
            if there:
                plan = run.planned(self._explored.way(state), subgoal.primitive)
                if plan is not None:
                    return plan
                self._subgoals.remove(subgoal)
        return None

    def _simulate_waiting(self) -> Plan | None:
        """The best primitive of those that wait, once simulations are allowed."""
        run = self._run
        if not self._waiting or run.work.seconds < self._simulate_from:
            return None
        _, state, primitive = heapq.heappop(self._waiting)
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
