"""The contract of pathfinding solvers, and what this one does with crowds."""

from __future__ import annotations

import numpy as np
import pytest

from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.testing.mapf_contract import MAPFSolverContract
from mamo_core.types.geometry import Box, Cylinder, make_pose
from mamo_core.types.mapf import (
    MAPFAgent,
    MAPFBudget,
    MAPFObstacle,
    MAPFProblem,
    MAPFStatus,
)
from mamo_core.types.region import SweptRegion
from mamo_core.verify_mapf import verify_mapf
from mamo_my_mapf.mapf import MyMapf, MyMapfOptions


class TestContract(MAPFSolverContract):
    """Tiny instances with answers known by hand; each check is a test."""

    complete = False

    def make_solver(self) -> MAPFSolver:
        return MyMapf(MyMapfOptions())


def crowd(seed: int) -> MAPFProblem:
    """Boxes and cylinders, some of them too near to each other, around a swept strip."""
    rng = np.random.default_rng(seed)
    cells = [(0.1 + 0.1 * i, 0.1 + 0.1 * j) for i in range(5) for j in range(5)]
    places = [cells[k] for k in rng.permutation(len(cells))[:9]]
    poses = [
        make_pose([*(np.array(place) + rng.uniform(-0.02, 0.02, 2)), 0.1], rng.uniform(0.0, 3.0))
        for place in places
    ]
    shapes = [
        Box(np.array([0.06, 0.07, 0.2])) if k % 2 else Cylinder(0.03, 0.2)
        for k in range(len(poses))
    ]
    lowest = np.full((60, 60), np.inf)
    lowest[0:35, 25:35] = 0.05
    agents = tuple(MAPFAgent(f"a{k}", shapes[k], poses[k]) for k in range(8))
    return MAPFProblem(
        agents=agents,
        obstacles=(MAPFObstacle("post", shapes[8], poses[8]),),
        region=SweptRegion(np.zeros(2), 0.01, lowest, 0.0),
        transit_lower=np.array([-0.05, 0.0]),
        transit_upper=np.array([0.6, 0.6]),
        goal_lower=np.zeros(2),
        goal_upper=np.array([0.6, 0.6]),
        margin=0.002,
        goal_margin=0.005,
        wait_cost=0.5,
    )


@pytest.mark.parametrize("seed", range(6))
def test_paths_pass_the_independent_check(seed: int) -> None:
    problem = crowd(seed)
    budget = MAPFBudget(nodes=10, expansions=30_000)
    solution = MyMapf(MyMapfOptions()).solve(problem, budget, np.random.default_rng(0))
    assert verify_mapf(problem, solution) == []
    assert solution.solved or solution.status is MAPFStatus.TIMEOUT
