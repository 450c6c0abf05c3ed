"""Compiles every kernel by solving a tiny problem, so that the first real one is not slow."""

from __future__ import annotations

import numpy as np

from mamo_core.types.geometry import Box, make_pose
from mamo_core.types.mapf import (
    CostField,
    GoalPenalty,
    MAPFAgent,
    MAPFBudget,
    MAPFObstacle,
    MAPFProblem,
)
from mamo_core.types.region import SweptRegion
from mamo_planners.mapf.convex import hull
from mamo_planners.mapf.solvers import cbs, ecbs, prioritized_planning


def warm_up() -> None:
    """Compiles (or loads from numba's cache) all kernels of this package."""
    cube = Box(np.array([0.04, 0.04, 0.04]))
    lowest = np.full((20, 20), np.inf)
    lowest[8:12, :12] = 0.01
    field = CostField(np.zeros(2), 0.1, np.full((2, 2), 0.5))
    penalty = GoalPenalty(np.array([0.15, 0.10]), 0.01, 1.0)
    problem = MAPFProblem(
        agents=(
            MAPFAgent("a", cube, make_pose([0.10, 0.10, 0.02]), (penalty,), field),
            MAPFAgent("b", cube, make_pose([0.05, 0.10, 0.02])),
            MAPFAgent("c", cube, make_pose([0.15, 0.10, 0.02], 0.3)),
        ),
        obstacles=(MAPFObstacle("o", cube, make_pose([0.10, 0.17, 0.02])),),
        region=SweptRegion(np.zeros(2), 0.01, lowest, 0.0),
        transit_lower=np.zeros(2),
        transit_upper=np.full(2, 0.2),
        goal_lower=np.zeros(2),
        goal_upper=np.full(2, 0.2),
        margin=0.002,
    )
    budget = MAPFBudget(nodes=20, expansions=20_000)
    for solver in (cbs(), ecbs(), prioritized_planning()):
        solver.solve(problem, budget, np.random.default_rng(0))
    # Compiled code calls it in the above, but for an object that leans Python does.
    hull(np.eye(3, 2), 3)
