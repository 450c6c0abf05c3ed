"""Selective Simulation (Saleem and Likhachev, 2020; thesis 3.5.1, 4.5.1, 5.6.1).

Plans while only the movables known to be relevant are simulated, then tracks the plan with all of
them; what breaks a constraint there becomes relevant, and it plans again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from mamo_core.interfaces.search_strategy import ProgressCallback, SearchStrategy
from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.types.geometry import Array
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import Mobility, SceneState
from mamo_core.types.solution import Budget, Plan, Solution, SolutionStatus, Statistics
from mamo_planners.baselines.options import SelectiveSimulationOptions
from mamo_planners.baselines.selective_planning import Planned, SelectivePlanning
from mamo_planners.reaching.goals import Goals
from mamo_planners.reaching.motions import Motions
from mamo_planners.reaching.scenery import look_at
from mamo_planners.reaching.stand import Executions, ReachingParts
from mamo_planners.search.judging import touched_by_arm

EngineFor = Callable[[Problem], TransitionModel]
"""The recipe's engine for another problem."""


class SelectiveSimulation(SearchStrategy):
    """Planning and tracking in turn until what is tracked is verified."""

    def __init__(
        self, parts: ReachingParts, engine_for: EngineFor, options: SelectiveSimulationOptions
    ) -> None:
        self._parts, self._engine_for, self._options = parts, engine_for, options

    def solve(
        self, budget: Budget, rng: np.random.Generator, progress: ProgressCallback
    ) -> Solution:
        statistics = Statistics()
        goals = Goals(
            self._parts.problem, self._parts.arm, self._parts.kinematics, self._parts.collision, rng
        )
        if not goals.known:
            words = "no pre-grasp can be taken up even without movables"
            return Solution(SolutionStatus.BUDGET_EXHAUSTED, None, statistics, words)
        scenery = look_at(self._parts, goals, self._options)
        tracking = _Tracking(self._parts, self._options, goals, statistics, budget)
        relevant: tuple[str, ...] = ()
        refuted: list[Array] = []
        while not budget.exhausted:
            progress(f"planning with {len(relevant)} relevant objects")
            statistics.counts["planning_phases"] += 1
            reduced = reduced_problem(self._parts.problem, relevant)
            planning = SelectivePlanning(
                replace(self._parts, backend=self._engine_for(reduced)),
                reduced,
                relevant,
                refuted,
                scenery,
                self._options,
                statistics,
                budget,
            )
            planned = planning.solve(rng)
            if planned is None:
                break
            tracked = tracking.track(planned, rng)
            if tracked.plan is not None:
                return Solution(SolutionStatus.SOLVED, tracked.plan, statistics)
            culprit = next((name for name in tracked.culprits if name not in relevant), None)
            if culprit is not None:
                relevant = (*relevant, culprit)
            elif tracked.failed_edge is not None:
                refuted.append(tracked.failed_edge)
            else:
                words = "the plan does not hold with all objects, and no other one is to blame"
                return Solution(SolutionStatus.BUDGET_EXHAUSTED, None, statistics, words)
        why = "no plan within the budget" if budget.exhausted else "no path past relevant objects"
        return Solution(SolutionStatus.BUDGET_EXHAUSTED, None, statistics, why)


@dataclass(frozen=True, eq=False)
class _Tracked:
    """A verified ``plan``, or movables to blame and, if a piece failed, its last edge (2, dof)."""

    plan: Plan | None
    culprits: tuple[str, ...] = ()
    failed_edge: Array | None = None


class _Tracking:
    """Executes plans with all objects."""

    def __init__(
        self,
        parts: ReachingParts,
        options: SelectiveSimulationOptions,
        goals: Goals,
        statistics: Statistics,
        budget: Budget,
    ) -> None:
        self._parts = parts
        self._motions = Motions(parts.arm, parts.kinematics, options, goals.opening)
        self._executions = Executions(parts, statistics, budget)
        objects = parts.problem.scene.objects
        self._movables = {o.name for o in objects if o.mobility is Mobility.MOVABLE}

    def track(self, planned: Planned, rng: np.random.Generator) -> _Tracked:
        """Execute it, and verify what comes of it."""
        executions = self._executions
        stand = executions.start(self._motions.opened(self._parts.problem.initial.joint_positions))
        if stand is None:
            return _Tracked(None, self._culprits())
        for piece in _pieces(planned):
            stand = executions.after(stand, self._motions.sweep(piece))
            if stand is None:
                return _Tracked(None, self._culprits(), piece[-2:])
        plan = executions.finished(stand, planned.goal, rng)
        if plan is not None:
            return _Tracked(plan)
        return _Tracked(None, self._culprits(), planned.path[-2:])  # a goal that leads nowhere

    def _culprits(self) -> tuple[str, ...]:
        result = self._executions.last
        return tuple(self._to_blame(result)) if result is not None else ()

    def _to_blame(self, result: RolloutResult) -> Iterator[str]:
        """Movables that broke constraints, first ones first; then what was moved, then touched.

        What merely stood in the way of an arm that stalled was only touched.
        """
        for violation in result.violations:
            for name in (violation.subject, violation.other):
                if name in self._movables:
                    yield name
        yield from (name for name in result.moved if name in self._movables)
        yield from (name for name in touched_by_arm(result) if name in self._movables)


def _pieces(planned: Planned) -> Iterator[Array]:
    """What was simulated edge by edge as it was, to rest; what is in between at once."""
    begin = 0
    for edge, simulated in enumerate(planned.simulated):
        if simulated:
            if begin < edge:
                yield planned.path[begin : edge + 1]
            yield planned.path[edge : edge + 2]
            begin = edge + 1
    if begin < len(planned.simulated):
        yield planned.path[begin:]


def reduced_problem(problem: Problem, relevant: tuple[str, ...]) -> Problem:
    """The problem without the movables that are not relevant."""
    scene = problem.scene
    kept = [
        i
        for i, item in enumerate(scene.objects)
        if item.mobility is not Mobility.MOVABLE or item.name in relevant
    ]
    objects = tuple(scene.objects[i] for i in kept)
    initial = SceneState(problem.initial.joint_positions, problem.initial.object_poses[kept])
    return replace(problem, scene=replace(scene, objects=objects), initial=initial)
