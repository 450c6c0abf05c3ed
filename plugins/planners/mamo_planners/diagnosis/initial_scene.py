"""A second look at the initial scene: is there a retrieval, who is stuck, what can be tried?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mamo_core.interfaces.action_generator import ActionRequest
from mamo_core.interfaces.retrieval import RetrievalPlanner
from mamo_core.types.mapf import MAPFBudget, MAPFProblem, MAPFStatus
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.solution import Solution, Statistics
from mamo_planners.diagnosis import blocked_actions, blocked_retrieval
from mamo_planners.diagnosis.blocked_paths import PathFinder, count_who_is_stuck
from mamo_planners.search.abstraction import mapf_problem, occupancy, occupied

if TYPE_CHECKING:
    from mamo_planners.search.run import SearchParts

_SEED = 0
_DRAWS = 4
"""NGRs looked at: that one of them cannot be cleared says nothing yet."""


def diagnose(
    parts: SearchParts, solution: Solution, mapf_budget: MAPFBudget, goal_margin: float
) -> Statistics:
    """What stands in the way at the start, under the causes of target and movables.

    ``blocked`` or the causes of an empty scene, if the target cannot be taken out even without
    movables; ``in_the_way`` for every movable in an NGR; causes of ``mapf`` if no NGR can be
    cleared even without physics, and the search never found out how to; otherwise ``blocked`` for
    every action that cannot even be tried with an object on its path.
    """
    statistics = Statistics()
    with statistics.timed("diagnosis"):
        regions = _looked_at(parts, solution)
        if regions:
            _count_in_the_way(parts.problem, regions, statistics)
            if parts.mapf is not None:
                finder = PathFinder(parts.mapf, mapf_budget)
                tasks = [_task(parts.problem, region, goal_margin) for region in regions]
                _count_who_cannot_leave(parts, tasks, finder, _found_paths(solution), statistics)
        elif not solution.statistics.counts["mapf_calls"]:  # nor has the search found one
            blocked_retrieval.count_what_blocks(parts.problem, parts.retrieval, statistics)
    return statistics


def _count_in_the_way(problem: Problem, regions: list[SweptRegion], statistics: Statistics) -> None:
    for region in regions:
        for name in occupied(problem, problem.initial, region):
            statistics.failed(name, "retrieval", "in_the_way")


def _count_who_cannot_leave(
    parts: SearchParts,
    tasks: list[MAPFProblem],
    finder: PathFinder,
    found_paths: bool,
    statistics: Statistics,
) -> None:
    """In the emptiest NGR: who is stuck, if none can be cleared; or what actions cannot try."""
    if not found_paths and all(finder.fails(task) for task in tasks):
        count_who_is_stuck(tasks[0], finder, statistics)
    else:
        _count_what_blocks_actions(parts, tasks[0], finder, statistics)


def _task(problem: Problem, region: SweptRegion, goal_margin: float) -> MAPFProblem:
    return mapf_problem(problem, problem.initial, region, {}, goal_margin)


def _count_what_blocks_actions(
    parts: SearchParts, task: MAPFProblem, finder: PathFinder, statistics: Statistics
) -> None:
    """For whom no action along its path can even be tried, in the emptiest NGR."""
    for name, path in finder.solved(task).paths.items():
        if len(path) < 2:
            continue
        request = ActionRequest(name, path, task.region)
        for kind, generator in parts.actions:
            blocked_actions.count_what_blocks(parts.problem, kind, generator, request, statistics)


def _looked_at(parts: SearchParts, solution: Solution) -> list[SweptRegion]:
    """NGRs of some retrievals; of more grasps, if the search has found one only with these."""
    regions = _regions(parts.problem, parts.retrieval)
    if not regions and solution.statistics.counts["mapf_calls"]:
        regions = _regions(parts.problem, parts.retrieval.thorough())
    return regions


def _found_paths(solution: Solution) -> bool:
    """Whether the search has ever found paths out of an NGR."""
    found = (MAPFStatus.OPTIMAL, MAPFStatus.BOUNDED, MAPFStatus.FEASIBLE)
    return any(solution.statistics.counts[f"mapf_{status}"] for status in found)


def _regions(problem: Problem, retrieval: RetrievalPlanner) -> list[SweptRegion]:
    """NGRs of some retrievals, those with the fewest objects first."""
    rng = np.random.default_rng(_SEED)
    initial = problem.initial
    found = [retrieval.plan(initial, rng, ignore_movables=True).motion for _ in range(_DRAWS)]
    regions = [retrieval.swept_region(initial, motion) for motion in found if motion is not None]
    return sorted(regions, key=lambda region: occupancy(problem, initial, region))
