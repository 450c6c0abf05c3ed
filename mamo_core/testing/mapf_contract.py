"""What every multi-agent pathfinding solver must do, as tests for plugin authors.

Use it by subclassing in a test file::

    class TestMySolver(MAPFSolverContract):
        def make_solver(self):
            return MySolver()

The instances are tiny, with answers known by hand. A solver may be incomplete: where it finds
nothing it must say TIMEOUT, and INFEASIBLE only where there is no solution.
"""

from __future__ import annotations

import numpy as np

from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.types.geometry import Box, make_pose
from mamo_core.types.mapf import (
    GoalPenalty,
    MAPFAgent,
    MAPFBudget,
    MAPFObstacle,
    MAPFProblem,
    MAPFSolution,
    MAPFStatus,
)
from mamo_core.types.region import SweptRegion
from mamo_core.verify_mapf import verify_mapf

CELL = 0.01
SIDE = 0.04
CLOSE = 1e-6


def instance(
    starts: dict[str, tuple[float, float]],
    swept: tuple[float, float, float, float] | None,
    size: tuple[float, float],
    penalties: dict[str, tuple[GoalPenalty, ...]] | None = None,
    walls: dict[str, tuple[float, float, float, float]] | None = None,
) -> MAPFProblem:
    """Cubes of 4 cm on a floor from (0, 0) to ``size`` metres.

    ``starts``: name -> centre; ``swept`` and ``walls``: least x, y, largest x, y; all metres.
    """
    cells = (round(size[0] / CELL), round(size[1] / CELL))
    lowest = np.full(cells, np.inf)
    if swept is not None:
        x = (np.arange(cells[0]) + 0.5) * CELL
        y = (np.arange(cells[1]) + 0.5) * CELL
        inside_x = (x > swept[0]) & (x < swept[2])
        inside_y = (y > swept[1]) & (y < swept[3])
        lowest[np.ix_(inside_x, inside_y)] = 0.01
    cube = Box(np.array([SIDE, SIDE, SIDE]))
    obstacles = tuple(
        MAPFObstacle(
            name,
            Box(np.array([x1 - x0, y1 - y0, SIDE])),
            make_pose([(x0 + x1) / 2.0, (y0 + y1) / 2.0, SIDE / 2.0]),
        )
        for name, (x0, y0, x1, y1) in (walls or {}).items()
    )
    return MAPFProblem(
        agents=tuple(
            MAPFAgent(name, cube, make_pose([*centre, SIDE / 2.0]), (penalties or {}).get(name, ()))
            for name, centre in starts.items()
        ),
        obstacles=obstacles,
        region=SweptRegion(np.zeros(2), CELL, lowest, 0.0),
        transit_lower=np.zeros(2),
        transit_upper=np.array(size),
        goal_lower=np.zeros(2),
        goal_upper=np.array(size),
    )


def one_in_a_lane(penalties: tuple[GoalPenalty, ...] = ()) -> MAPFProblem:
    """One cube in a lane of its own width; x beyond 0.12 is free. Nearest goal: 9 steps off.

    The cube must clear the centre of the last swept cell by half a diagonal: at 0.15 or beyond.
    """
    return instance({"a": (0.06, 0.02)}, (0.0, 0.0, 0.12, 0.04), (0.30, 0.04), {"a": penalties})


def one_must_give_way() -> MAPFProblem:
    """``b`` stands, already well, in the only way out of ``a``; both fit in beyond it.

    Lane y 0..0.04; x up to 0.12 swept; ``b`` at 0.15, so ``a`` ends at 0.15 only if ``b`` is at
    0.19 or more: 9 steps for ``a`` and 4 for ``b``, and none more are needed.
    """
    return instance({"a": (0.06, 0.02), "b": (0.15, 0.02)}, (0.0, 0.0, 0.12, 0.04), (0.30, 0.04))


def one_must_step_aside() -> MAPFProblem:
    """``a`` must get past ``b``, whose only way aside is a bay: 14 steps and 4.

    Lane y 0..0.04 with a bay above x 0.13..0.17. ``a`` may end at x >= 0.20 alone, and the lane
    ends at 0.24, so ``b`` cannot dodge to the right.
    """
    left = GoalPenalty(np.array([0.05, 0.02]), 0.1451, float("inf"))
    return instance(
        {"a": (0.06, 0.02), "b": (0.15, 0.02)},
        None,
        (0.24, 0.08),
        {"a": (left,)},
        {"low": (0.0, 0.04, 0.13, 0.08), "high": (0.17, 0.04, 0.24, 0.08)},
    )


def nowhere_to_go() -> MAPFProblem:
    """One cube, and everything it can reach is swept."""
    return instance(
        {"a": (0.06, 0.02), "b": (0.27, 0.02)},
        (0.0, 0.0, 0.16, 0.04),
        (0.30, 0.04),
        walls={"wall": (0.17, 0.0, 0.19, 0.04)},
    )


class MAPFSolverContract:
    """Checks of a solver; override ``make_solver``."""

    budget = MAPFBudget(nodes=2_000, expansions=2_000_000)
    """Work allowed on each instance; enough for a complete solver."""
    complete = True
    """Whether it must solve every solvable instance here; False for prioritised planning."""

    def make_solver(self) -> MAPFSolver:
        """The solver under test, fresh."""
        raise NotImplementedError("override make_solver")

    def solve(self, problem: MAPFProblem, budget: MAPFBudget | None = None) -> MAPFSolution:
        """A solution with a fixed generator."""
        return self.make_solver().solve(problem, budget or self.budget, np.random.default_rng(7))

    def solved(self, problem: MAPFProblem, optimum: float) -> MAPFSolution:
        """A solution whose paths, cost, bounds and status agree with each other and the optimum."""
        solution = self.solve(problem)
        assert solution.solved, f"status {solution.status}, expected a solution"
        assert verify_mapf(problem, solution) == []
        assert solution.cost >= optimum - CLOSE, "cheaper than the optimum"
        assert solution.lower_bound <= optimum + CLOSE, "lower bound above the optimum"
        assert solution.cost <= solution.bound * optimum + CLOSE, "the bound does not hold"
        if solution.status is MAPFStatus.OPTIMAL:
            assert abs(solution.cost - optimum) <= CLOSE, "claimed optimal, and is not"
        return solution

    def test_one_agent_walks_out_by_the_shortest_way(self) -> None:
        self.solved(one_in_a_lane(), 9.0)

    def test_an_agent_outside_stays_at_no_cost(self) -> None:
        problem = instance({"a": (0.25, 0.02)}, (0.0, 0.0, 0.12, 0.04), (0.30, 0.04))
        solution = self.solved(problem, 0.0)
        assert len(solution.paths["a"]) == 1

    def test_agents_do_not_run_into_each_other(self) -> None:
        self.solved(one_must_give_way(), 13.0)

    def test_agents_do_not_run_into_obstacles(self) -> None:
        # The shortest way out leads through the pillar: round it is 3 steps more.
        problem = instance(
            {"a": (0.06, 0.06)},
            (0.0, 0.0, 0.12, 0.12),
            (0.30, 0.12),
            walls={"pillar": (0.10, 0.05, 0.12, 0.12)},
        )
        self.solved(problem, 12.0)

    def test_one_steps_aside_for_the_other(self) -> None:
        problem = one_must_step_aside()
        if self.complete:
            self.solved(problem, 18.0)
            return
        solution = self.solve(problem)
        assert verify_mapf(problem, solution) == []
        assert solution.status is not MAPFStatus.INFEASIBLE, "infeasible is wrong: there is a way"

    def test_nobody_claims_a_solution_where_there_is_none(self) -> None:
        solution = self.solve(nowhere_to_go())
        assert solution.status in (MAPFStatus.INFEASIBLE, MAPFStatus.TIMEOUT)
        assert not solution.paths
        if self.complete:
            assert solution.status is MAPFStatus.INFEASIBLE
            assert set(solution.blame) == {"a"}, "the agent to blame is 'a'"

    def test_forbidden_goals_are_not_used(self) -> None:
        forbidden = GoalPenalty(np.array([0.15, 0.02]), 0.0251, float("inf"))
        self.solved(one_in_a_lane((forbidden,)), 12.0)

    def test_a_start_may_be_forbidden_too(self) -> None:
        start = GoalPenalty(np.array([0.15, 0.02]), 0.0151, float("inf"))
        problem = instance({"a": (0.15, 0.02)}, None, (0.30, 0.04), {"a": (start,)})
        self.solved(problem, 2.0)

    def test_penalties_are_weighed_against_steps(self) -> None:
        cheap = GoalPenalty(np.array([0.15, 0.02]), 0.0251, 2.0)
        self.solved(one_in_a_lane((cheap,)), 11.0)
        dear = GoalPenalty(np.array([0.15, 0.02]), 0.0251, 5.0)
        self.solved(one_in_a_lane((dear,)), 12.0)

    def test_penalties_of_one_place_add_up(self) -> None:
        place = GoalPenalty(np.array([0.15, 0.02]), 0.0251, 2.0)
        self.solved(one_in_a_lane((place, place)), 12.0)

    def test_equal_inputs_give_equal_paths(self) -> None:
        for problem in (one_must_give_way(), one_must_step_aside(), open_field()):
            first, second = self.solve(problem), self.solve(problem)
            assert first.status is second.status
            assert first.cost == second.cost or not first.solved
            for name in first.paths:
                assert np.array_equal(first.paths[name], second.paths[name]), name

    def test_little_work_gives_an_honest_answer(self) -> None:
        for nodes, expansions in ((0, 0), (1, 1), (1, 50), (3, 10_000)):
            problem = one_must_step_aside()
            solution = self.solve(problem, MAPFBudget(nodes, expansions))
            assert verify_mapf(problem, solution) == []
            assert solution.solved or solution.status is MAPFStatus.TIMEOUT

    def test_no_agents_is_solved(self) -> None:
        solution = self.solve(instance({}, None, (0.30, 0.04)))
        assert solution.solved
        assert solution.cost == 0.0


def open_field() -> MAPFProblem:
    """Three cubes in a swept square with many equally good ways out."""
    return instance(
        {"a": (0.10, 0.10), "b": (0.15, 0.10), "c": (0.10, 0.15)},
        (0.06, 0.06, 0.20, 0.20),
        (0.30, 0.30),
    )
