"""SPAMP (thesis, Algorithms 2 and 3): only the last motion may push, and only it is simulated."""

from __future__ import annotations

import numpy as np

from mamo_core.interfaces.search_strategy import ProgressCallback, SearchStrategy
from mamo_core.types.geometry import Array
from mamo_core.types.motion import MotionSegment, Trajectory
from mamo_core.types.solution import Budget, Plan, Solution, SolutionStatus, Statistics
from mamo_planners.reaching.amp import Mix, Primitives
from mamo_planners.reaching.goals import Goals
from mamo_planners.reaching.lattice import Lattice
from mamo_planners.reaching.motions import Motions
from mamo_planners.reaching.options import SpampOptions
from mamo_planners.reaching.primitive import Primitive
from mamo_planners.reaching.promising import Promising
from mamo_planners.reaching.scenery import Scenery, look_at
from mamo_planners.reaching.shortcuts import straightened
from mamo_planners.reaching.soft_duplicates import SoftDuplicates
from mamo_planners.reaching.spamp_search import Subgoal, SubgoalSearch
from mamo_planners.reaching.stand import Executions, ReachingParts
from mamo_planners.reaching.work import Work


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
        run = Run(parts, self._options, scenery, statistics, budget, rng)
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


class Run:
    """One call of ``solve``; primitives that failed are remembered from round to round."""

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
        slow = options.model_copy(update={"sweep_speed": options.slow_speed})
        self._brisk, self._slow = (
            Motions(parts.arm, parts.kinematics, speeds, scenery.goals.opening)
            for speeds in (options, slow)
        )
        self.motions = self._brisk
        self.executions = Executions(parts, statistics, budget)
        self.promising = Promising()
        self.primitives = Primitives(
            parts.arm,
            parts.kinematics,
            scenery.goals,
            scenery.fixed,
            scenery.everything,
            scenery.field,
            self.promising,
            options.delta,
        )
        self.work = Work()
        self.duplicates = SoftDuplicates(options.beta)
        self._out_of_reach = SoftDuplicates(options.beta)

    def round(self, number: int) -> Plan | None:
        """Algorithm 2: subgoals, then the search they guide."""
        options = self.options
        self.motions = self._slow if number % 2 == 0 else self._brisk
        wider = options.delta * (1.0 + options.growth * (number - 1))
        self.primitives.delta = min(wider, max(options.widest, options.delta))
        subgoals = self._subgoals(Mix(options.via, options.vary) if number > 1 else Mix())
        plan = self._connected(subgoals) if options.connect else None
        if plan is not None:
            return plan
        any_valid = any(subgoal.valid for subgoal in subgoals)
        simulate_from = self.work.seconds + (options.t_sim if any_valid else 0.0)
        return SubgoalSearch(self, subgoals, simulate_from).solve(
            luby(number) * self.options.expansions
        )

    def valid(self, primitive: Primitive) -> bool:
        """Phase 2: simulate what may touch movables; what fails is remembered."""
        if not primitive.interacts:
            return True
        self.statistics.counts["simulated_primitives"] += 1
        steps = self.statistics.counts["steps"]
        sweep = self.motions.sweep(primitive.sweep)
        result = self.executions.alone(sweep)
        self.work.simulated(self.statistics.counts["steps"] - steps)
        if not result.valid:
            self.duplicates.failed(primitive.start)
            self.promising.failed(primitive, _left(sweep.trajectory, result.duration))
        return result.valid

    def planned(self, way: Array, primitive: Primitive) -> Plan | None:
        """The plan that goes along ``way`` (k, dof) and ends with the primitive, if it holds."""
        gone = self._gone(np.vstack([way, primitive.approach]))
        sweep = [self.motions.sweep(primitive.sweep)] if primitive.interacts else []
        return self._finished([self.motions.opened(self.start), *gone, *sweep], primitive)

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
            self.duplicates.failed(primitive.start)
        return plan

    def _connected(self, subgoals: list[Subgoal]) -> Plan | None:
        """The way to a valid subgoal that the arm planner finds; one that does not do is left.

        What is out of reach is remembered: nothing more is drawn close to it.
        """
        left = [subgoal for subgoal in subgoals if subgoal.valid]
        while left:
            goals = np.array([subgoal.primitive.start for subgoal in left])
            with self.statistics.timed("arm_planning"):
                found = self.arm_planner.plan(self.start, goals, self.scenery.everything, self.rng)
            if found.path is None:
                for subgoal in left:
                    self._out_of_reach.failed(subgoal.primitive.start)
                return None
            subgoal = left.pop(found.goal)
            plan = self.planned(found.path, subgoal.primitive)
            if plan is not None:
                return plan
            subgoals.remove(subgoal)
        return None

    def _subgoals(self, mix: Mix) -> list[Subgoal]:
        """N of up to M primitives, valid ones first (GetValidSubgoals of Algorithm 2)."""
        options = self.options
        if not options.subgoals or not options.samples:
            return []
        drawn: list[Subgoal] = []
        for primitive in self.primitives.drawn(self.rng, self._rounded, mix):
            if self._out_of_reach.near(primitive.start):
                continue
            cell = self.lattice.nearest(primitive.start)
            valid = not primitive.interacts or (options.simulate_samples and self.valid(primitive))
            drawn.append(Subgoal(cell, primitive, valid))
            enough = sum(subgoal.valid for subgoal in drawn) >= options.enough
            if enough or len(drawn) >= options.samples or self.budget.exhausted:
                break
        self.statistics.counts["drawn_primitives"] += len(drawn)
        drawn.sort(key=lambda subgoal: not subgoal.valid)
        return drawn[: options.subgoals]

    def _rounded(self, q: Array) -> Array:
        return self.lattice.configuration(self.lattice.nearest(q))


def _left(trajectory: Trajectory, time: float) -> float:
    """What a trajectory has still to go at ``time`` (s): length of its path, rad."""
    rest = np.vstack(
        [trajectory.at(np.array([time])), trajectory.positions[trajectory.times > time]]
    )
    return float(np.linalg.norm(np.diff(rest, axis=0), axis=1).sum())


def luby(number: int) -> int:
    """The n-th term (from 1) of 1, 1, 2, 1, 1, 2, 4, …: how long to try before starting anew.

    No other sequence is much better where the time to success is unknown (Luby et al., 1993).
    """
    power = number.bit_length()
    if number == (1 << power) - 1:
        return 1 << (power - 1)
    return luby(number - (1 << (power - 1)) + 1)
