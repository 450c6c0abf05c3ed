"""The solvers on thesis scenes and in special situations."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from mamo_planners.mapf import warm_up
from mamo_planners.mapf.solvers import cbs, ecbs, portfolio, prioritized_planning

from mamo_core.errors import InputError
from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.testing.mapf_contract import instance, nowhere_to_go, one_in_a_lane
from mamo_core.types.geometry import frozen_array, make_pose
from mamo_core.types.mapf import GoalPenalty, MAPFBudget, MAPFProblem, MAPFSolution, MAPFStatus
from mamo_core.verify_mapf import verify_mapf

SMALL = MAPFBudget(nodes=400, expansions=60_000)


def solve(solver: MAPFSolver, problem: MAPFProblem, budget: MAPFBudget = SMALL) -> MAPFSolution:
    solution = solver.solve(problem, budget, np.random.default_rng(1))
    assert verify_mapf(problem, solution) == []
    return solution


def test_warming_up_works_twice() -> None:
    warm_up()
    warm_up()


def test_components_can_be_listed_without_numba() -> None:
    code = (
        "import sys, mamo_planners.mapf.components; "
        "sys.exit('numba' in sys.modules or 'scipy' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.scenes
@pytest.mark.parametrize("movables", [5, 10, 15])
def test_the_portfolio_solves_the_thesis_scenes(
    movables: int, thesis_problems: Callable[..., list[MAPFProblem]]
) -> None:
    settings = {"margin": 0.003, "goal_margin": 0.005, "wait_cost": 0.5}
    for problem in thesis_problems(movables, 8, **settings):
        solution = solve(portfolio(), problem, MAPFBudget())
        assert solution.solved
        again = solve(portfolio(), problem, MAPFBudget())
        assert again.cost == solution.cost
        for name, path in solution.paths.items():
            assert np.array_equal(path, again.paths[name])


@pytest.mark.scenes
def test_bounds_of_different_solvers_agree(
    thesis_problems: Callable[..., list[MAPFProblem]],
) -> None:
    for problem in thesis_problems(10, 8):
        found = [
            solve(solver, problem)
            for solver in (cbs(), cbs(1), ecbs(1.5), ecbs(3.0), prioritized_planning(5))
        ]
        least = min(s.cost for s in found)
        for solution in found:
            assert solution.lower_bound <= least + 1e-6
            assert solution.expansions <= SMALL.expansions
            assert solution.nodes <= SMALL.nodes
        exact = {s.cost for s in found if s.status is MAPFStatus.OPTIMAL}
        assert len(exact) <= 1
        assert found[2].status is MAPFStatus.TIMEOUT or found[2].bound <= 1.5 + 1e-9


@pytest.mark.scenes
def test_penalties_that_pile_up_stay_solvable(
    thesis_problems: Callable[..., list[MAPFProblem]],
) -> None:
    for problem in thesis_problems(10, 4):
        cost = 0.0
        for _ in range(4):
            solution = solve(portfolio(), problem, MAPFBudget())
            assert solution.solved
            assert solution.bound * solution.cost >= cost - 1e-6
            cost = solution.lower_bound
            problem = _penalised(problem, solution)


def _penalised(problem: MAPFProblem, solution: MAPFSolution) -> MAPFProblem:
    """Each goal that was moved to costs 10 more within 2 cm, as after a failed push."""
    agents = tuple(
        replace(a, penalties=(*a.penalties, GoalPenalty(path[-1], 0.02, 10.0)))
        if len(path := solution.paths[a.name]) > 1
        else a
        for a in problem.agents
    )
    return replace(problem, agents=agents)


def test_blame_names_those_that_can_never_get_out() -> None:
    solution = solve(portfolio(), nowhere_to_go())
    assert solution.status is MAPFStatus.INFEASIBLE
    assert set(solution.blame) == {"a"}
    assert "reached" in solution.blame["a"]
    everywhere = GoalPenalty(np.zeros(2), 1.0, float("inf"))
    solution = solve(portfolio(), one_in_a_lane((everywhere,)))
    assert "no position within the goal bounds" in solution.blame["a"]


def test_a_pair_in_each_others_way_for_good_is_no_reason_to_blame_one() -> None:
    # Two cubes in a lane whose unswept end has room for one.
    problem = instance({"a": (0.02, 0.02), "b": (0.07, 0.02)}, (0.0, 0.0, 0.10, 0.04), (0.18, 0.04))
    for solver in (cbs(), ecbs(), prioritized_planning(), portfolio()):
        solution = solve(solver, problem)
        assert solution.status in (MAPFStatus.INFEASIBLE, MAPFStatus.TIMEOUT)
        assert not solution.blame


def test_touching_objects_may_part_and_are_kept_apart_then() -> None:
    # Nearer than the margin at the start, with b in a's way.
    problem = instance(
        {"a": (0.06, 0.02), "b": (0.102, 0.02)}, (0.0, 0.0, 0.12, 0.04), (0.30, 0.04)
    )
    problem = replace(problem, margin=0.005)
    solution = solve(cbs(), problem)
    assert solution.status is MAPFStatus.OPTIMAL
    # They never part: a goes 9 steps to 0.15 and pushes b before it, as near as they began.
    assert solution.cost == pytest.approx(18.0)
    # Having parted once, as here with b moved first, they would have to keep the margin.
    apart = replace(problem.agents[1], pose=make_pose([0.112, 0.02, 0.02]))
    solution = solve(cbs(), replace(problem, agents=(problem.agents[0], apart)))
    assert solution.cost == pytest.approx(18.0)


def test_an_agent_that_starts_out_of_bounds_in_an_obstacle_can_leave() -> None:
    problem = instance(
        {"a": (0.01, 0.05)},
        (0.0, 0.0, 0.12, 0.10),
        (0.30, 0.10),
        walls={"post": (0.0, 0.06, 0.02, 0.10)},
    )
    solution = solve(cbs(), problem)
    assert solution.status is MAPFStatus.OPTIMAL
    assert solution.cost == pytest.approx(14.0)


def test_a_tilted_object_is_taken_larger() -> None:
    problem = one_in_a_lane()
    agent = problem.agents[0]
    lean = frozen_array([*agent.pose[:3], np.cos(0.35), 0.0, np.sin(0.35), 0.0], "pose", (7,))
    wide = replace(
        problem,
        agents=(replace(agent, pose=lean),),
        transit_lower=np.array([-0.01, -0.01]),
        goal_lower=np.array([-0.01, -0.01]),
    )
    solution = solve(cbs(), wide)
    assert solution.cost == pytest.approx(10.0)


def test_two_leave_through_a_gap_however_cheap_waits_are() -> None:
    for wait in (0.1, 1.0):
        problem = instance(
            {"a": (0.06, 0.06), "b": (0.12, 0.06)},
            (0.0, 0.0, 0.16, 0.12),
            (0.34, 0.12),
            walls={"low": (0.16, 0.0, 0.20, 0.04), "high": (0.16, 0.08, 0.20, 0.12)},
        )
        assert solve(portfolio(), replace(problem, wait_cost=wait)).solved


def test_shares_above_the_whole_are_refused() -> None:
    with pytest.raises(InputError, match="at most 1"):
        portfolio(cbs_share=0.9, tight=(0.5, 1.5))
