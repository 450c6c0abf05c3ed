"""The verifier finds each kind of violation, and nothing in a good solution."""

from __future__ import annotations

from dataclasses import replace

import fcl
import numpy as np
import numpy.typing as npt
import pytest

from mamo_core.testing.mapf_contract import instance
from mamo_core.types.geometry import Array, Box, Cylinder, Shape, make_pose
from mamo_core.types.mapf import CostField, GoalPenalty, MAPFProblem, MAPFSolution, MAPFStatus
from mamo_core.verify_mapf import _gap, _outline, verify_mapf


def steps(start: tuple[float, float], moves: str) -> Array:
    """The path of a word of r, l, u, d (right, left, up, down a centimetre) and w (wait)."""
    offsets = {"r": (1, 0), "l": (-1, 0), "u": (0, 1), "d": (0, -1), "w": (0, 0)}
    deltas = np.array([(0, 0), *(offsets[m] for m in moves)])
    return np.array(start) + 0.01 * np.cumsum(deltas, axis=0)


def solution(cost: float, **paths: Array) -> MAPFSolution:
    return MAPFSolution(MAPFStatus.OPTIMAL, paths, cost, cost, 1.0)


@pytest.fixture
def problem() -> MAPFProblem:
    """``a`` 9 steps from being out of the region, ``b`` beside its way, a wall above."""
    return instance(
        {"a": (0.06, 0.02), "b": (0.23, 0.10)},
        (0.0, 0.0, 0.12, 0.04),
        (0.30, 0.20),
        walls={"wall": (0.0, 0.06, 0.16, 0.08)},
    )


GOOD = steps((0.06, 0.02), "r" * 9)
STAYS = steps((0.23, 0.10), "")


def says(problem: MAPFProblem, answer: MAPFSolution, words: str) -> None:
    found = verify_mapf(problem, answer)
    assert any(words in line for line in found), found


def test_a_good_solution_has_nothing_wrong(problem: MAPFProblem) -> None:
    assert verify_mapf(problem, solution(9.0, a=GOOD, b=STAYS)) == []


def test_a_missing_path(problem: MAPFProblem) -> None:
    says(problem, solution(9.0, a=GOOD), "b: no path")


def test_a_path_of_nobody(problem: MAPFProblem) -> None:
    says(problem, solution(9.0, a=GOOD, b=STAYS, c=STAYS), "c: a path of no agent")


def test_a_path_of_the_wrong_shape(problem: MAPFProblem) -> None:
    says(problem, solution(9.0, a=GOOD[:0], b=STAYS), "a: path of shape")


def test_a_wrong_start(problem: MAPFProblem) -> None:
    says(problem, solution(8.0, a=GOOD[1:], b=STAYS), "a: starts at")


@pytest.mark.parametrize("jump", [(0.02, 0.0), (0.01, 0.01), (0.005, 0.0)])
def test_a_step_that_is_no_lattice_step(problem: MAPFProblem, jump: tuple[float, float]) -> None:
    path = np.concatenate([GOOD, [GOOD[-1] + jump]])
    says(problem, solution(10.0, a=path, b=STAYS), "not one lattice step")


def test_leaving_the_bounds(problem: MAPFProblem) -> None:
    path = steps((0.06, 0.02), "d" + "r" * 9 + "u")
    says(problem, solution(11.0, a=path, b=STAYS), "out of bounds at step 1")


def test_running_into_an_obstacle(problem: MAPFProblem) -> None:
    path = steps((0.06, 0.02), "uuu" + "r" * 9)
    says(problem, solution(12.0, a=path, b=STAYS), "from wall at step 3")


def test_too_near_an_obstacle(problem: MAPFProblem) -> None:
    wide = replace(problem, margin=0.005)
    near = steps((0.23, 0.10), "l" * 5)
    assert verify_mapf(problem, solution(14.0, a=GOOD, b=near)) == []
    says(wide, solution(14.0, a=GOOD, b=near), "from wall at step 5")


def test_an_agent_that_starts_in_an_obstacle_may_leave_but_not_go_deeper() -> None:
    problem = instance(
        {"a": (0.15, 0.02)},
        (0.0, 0.0, 0.16, 0.04),
        (0.30, 0.04),
        walls={"post": (0.16, 0.01, 0.18, 0.03)},
    )
    beside = replace(problem, transit_upper=np.array([0.30, 0.20]), transit_lower=-np.ones(2))
    beside = replace(beside, goal_upper=beside.transit_upper, goal_lower=beside.transit_lower)
    assert verify_mapf(beside, solution(6.0, a=steps((0.15, 0.02), "u" * 6))) == []
    says(beside, solution(9.0, a=steps((0.15, 0.02), "r" * 9)), "from post at step 1")


def test_running_into_each_other(problem: MAPFProblem) -> None:
    meeting = steps((0.23, 0.10), "d" * 7 + "l" * 5)
    says(problem, solution(21.0, a=GOOD, b=meeting), "a and b: too close at step 12")


def test_running_into_one_that_has_arrived_counts_after_its_path_ends(
    problem: MAPFProblem,
) -> None:
    late = steps((0.23, 0.10), "w" * 20 + "d" * 8 + "l" * 5)
    says(problem, solution(42.0, a=GOOD, b=late), "a and b: too close")


def test_a_margin_between_agents(problem: MAPFProblem) -> None:
    near = steps((0.23, 0.10), "d" * 8 + "l" * 4)
    assert verify_mapf(problem, solution(21.0, a=GOOD, b=near)) == []
    says(replace(problem, margin=0.002), solution(21.0, a=GOOD, b=near), "too close")


def test_a_pair_that_starts_too_close_may_part_but_not_meet_again() -> None:
    problem = instance({"a": (0.10, 0.10), "b": (0.138, 0.10)}, None, (0.30, 0.30))
    apart = steps((0.138, 0.10), "rr")
    stays = steps((0.10, 0.10), "")
    assert verify_mapf(problem, solution(2.0, a=stays, b=apart)) == []
    again = steps((0.138, 0.10), "rrll")
    says(problem, solution(4.0, a=stays, b=again), "a and b: too close at step 4")


def test_ending_inside_the_region(problem: MAPFProblem) -> None:
    says(problem, solution(8.0, a=GOOD[:-1], b=STAYS), "a: ends inside the region")


def test_the_goal_margin_counts_for_goals_and_not_for_those_that_stay(
    problem: MAPFProblem,
) -> None:
    wide = replace(problem, goal_margin=0.01)
    says(wide, solution(9.0, a=GOOD, b=STAYS), "a: ends inside the region")
    beside = instance({"a": (0.15, 0.02)}, (0.0, 0.0, 0.12, 0.04), (0.30, 0.20))
    beside = replace(beside, goal_margin=0.01)
    assert verify_mapf(beside, solution(0.0, a=steps((0.15, 0.02), ""))) == []


def test_ending_out_of_the_goal_bounds(problem: MAPFProblem) -> None:
    narrow = replace(problem, goal_upper=np.array([0.16, 0.20]))
    found = verify_mapf(narrow, solution(9.0, a=GOOD, b=STAYS))
    assert found == ["a: ends out of the goal bounds"]  # b never moves: exempt


def test_ending_at_a_forbidden_place(problem: MAPFProblem) -> None:
    penalty = GoalPenalty(np.array([0.15, 0.02]), 0.005, float("inf"))
    a, b = problem.agents
    says(
        replace(problem, agents=(replace(a, penalties=(penalty,)), b)),
        solution(9.0, a=GOOD, b=STAYS),
        "a: ends at a forbidden place",
    )


def test_a_wrong_cost_is_found_with_waits_fields_and_penalties(problem: MAPFProblem) -> None:
    a, b = problem.agents
    field = CostField(np.array([0.10, 0.0]), 0.10, np.full((1, 1), 0.5))
    penalty = GoalPenalty(np.array([0.15, 0.02]), 0.005, 4.0)
    priced = replace(
        problem,
        agents=(replace(a, cost_field=field, penalties=(penalty,)), b),
        wait_cost=0.1,
    )
    waits = steps((0.06, 0.02), "ww" + "r" * 9 + "www")
    # 9 moves, 2 waits on the way, 6 cells (x 0.10..0.15) in the field, the penalty.
    right = 9.0 + 0.2 + 3.0 + 4.0
    assert verify_mapf(priced, solution(right, a=waits, b=STAYS)) == []
    says(priced, solution(9.0, a=waits, b=STAYS), "paid")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"lower_bound": 9.5}, "above the cost"),
        ({"bound": 0.5}, "does not follow"),
        ({"lower_bound": 5.0}, "does not follow"),
        ({"lower_bound": 6.0, "bound": 1.5}, "status optimal with bound"),
        ({"status": MAPFStatus.BOUNDED, "bound": float("inf")}, "without a bound"),
        ({"status": MAPFStatus.TIMEOUT}, "comes with paths"),
    ],
)
def test_claims_that_do_not_fit(problem: MAPFProblem, change: dict[str, float], words: str) -> None:
    answer = replace(solution(9.0, a=GOOD, b=STAYS), **change)  # type: ignore[arg-type]
    says(problem, answer, words)


def test_no_solution_has_nothing_wrong(problem: MAPFProblem) -> None:
    assert verify_mapf(problem, MAPFSolution(MAPFStatus.TIMEOUT)) == []


def _random_shape(rng: np.random.Generator) -> Shape:
    if rng.random() < 0.5:
        return Cylinder(float(rng.uniform(0.02, 0.05)), 0.1)
    return Box(np.array([*rng.uniform(0.03, 0.12, 2), 0.1]))


def _fcl_object(shape: Shape, pose: npt.NDArray[np.float64]) -> fcl.CollisionObject:
    if isinstance(shape, Box):
        body = fcl.Box(*shape.size)
    else:
        body = fcl.Cylinder(shape.radius, shape.height)
    return fcl.CollisionObject(body, fcl.Transform(pose[3:], pose[:3]))


def test_gaps_agree_with_fcl() -> None:
    rng = np.random.default_rng(3)
    for _ in range(300):
        first, second = _random_shape(rng), _random_shape(rng)
        a = make_pose([0.0, 0.0, 0.05], rng.uniform(0, 6.3))
        b = make_pose([*rng.uniform(-0.15, 0.15, 2), 0.05], rng.uniform(0, 6.3))
        gap = _gap(_outline(first, a), a[:2], _outline(second, b), b[:2])
        one, other = _fcl_object(first, a), _fcl_object(second, b)
        touch = fcl.collide(one, other, fcl.CollisionRequest(), fcl.CollisionResult())
        if abs(gap) > 1e-4:
            assert (gap < 0.0) == bool(touch)
        if gap > 1e-3:
            distance = fcl.distance(one, other, fcl.DistanceRequest(), fcl.DistanceResult())
            assert gap == pytest.approx(distance, abs=2e-4)
