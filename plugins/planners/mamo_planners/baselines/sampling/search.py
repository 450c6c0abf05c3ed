"""What all baselines have in common: goals first, then a tree that grows until there is a plan."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mamo_core.interfaces.search_strategy import ProgressCallback, SearchStrategy
from mamo_core.types.solution import Budget, Plan, Solution, SolutionStatus, Statistics
from mamo_planners.baselines.sampling.growth import Growth, Node
from mamo_planners.baselines.sampling.options import SamplingOptions
from mamo_planners.reaching.goals import Goals
from mamo_planners.reaching.stand import ReachingParts

Grow = Callable[[Growth, Node], "Plan | None"]
"""Grows a tree from its root until a plan is verified or the growth is over."""


class SamplingSearch(SearchStrategy):
    """A sampling-based planner over the states of arm and objects; it proves nothing."""

    def __init__(self, parts: ReachingParts, options: SamplingOptions, grow: Grow) -> None:
        self._parts, self._options, self._grow = parts, options, grow

    def solve(
        self, budget: Budget, rng: np.random.Generator, progress: ProgressCallback
    ) -> Solution:
        parts, statistics = self._parts, Statistics()
        with statistics.timed("goals"):
            goals = Goals(parts.problem, parts.arm, parts.kinematics, parts.collision, rng)
        if not goals.known:
            return _without(statistics, "no pre-grasp can be taken up even without movables")
        growth = Growth(parts, self._options, goals, statistics, budget, rng)
        root = growth.root()
        if root is None:
            return _without(statistics, "the hand cannot be opened where the arm is")
        progress("the tree grows")
        plan = self._grow(growth, root)
        if plan is not None:
            return Solution(SolutionStatus.SOLVED, plan, statistics)
        if budget.exhausted:
            return _without(statistics, "no plan within the budget")
        return _without(statistics, "no plan within the limits on work")


def _without(statistics: Statistics, reason: str) -> Solution:
    return Solution(SolutionStatus.BUDGET_EXHAUSTED, None, statistics, reason)
