"""What the search does in tiny worlds with known answers; a plan takes milliseconds."""

from __future__ import annotations

import numpy as np
import pytest

from mamo_core.interfaces.arm_planner import ArmPlan, ArmPlanner, ArmPlanStatus
from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.testing.fakes import StraightPush, StraightRetrieval
from mamo_core.testing.flat_checker import FlatChecker
from mamo_core.testing.gantry import GantryKinematics
from mamo_core.testing.gantry_arm import gantry_arm
from mamo_core.testing.quasi_static import QuasiStaticModel
from mamo_core.testing.scenes import TinyScene, clear_scene, one_blocker, two_blockers, walled_in
from mamo_core.testing.transition_cases import standard_constraints
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.solution import Budget, Plan, Solution, SolutionStatus
from mamo_core.verify import VerifyReport
from mamo_my_search.search import MySearch, MySearchOptions


class Straight(ArmPlanner):
    """The straight motion."""

    def plan(
        self,
        start: Array,
        goals: Array,
        world: CollisionWorld,
        rng: np.random.Generator,
        *,
        max_checks: int | None = None,
    ) -> ArmPlan:
        return ArmPlan(ArmPlanStatus.SOLVED, np.stack([start, goals[0]]), 0, 1)


def engine_of(problem: Problem) -> QuasiStaticModel:
    return QuasiStaticModel(problem, GantryKinematics().forward, standard_constraints(problem))


def replayed(problem: Problem, plan: Plan) -> VerifyReport:
    """The whole plan in one rollout from the start, as ``mamo verify`` does it."""
    segments = [segment for motion in plan.motions for segment in motion.segments]
    whole = Motion(tuple(segments), plan.motions[0].opening)
    result = engine_of(problem).rollout(problem.initial, whole)
    return VerifyReport(() if result.valid else ("broken",), result)


def solved(
    scene: TinyScene, seed: int = 0, seconds: float = float("inf"), **options: int
) -> Solution:
    problem = scene.problem
    search = MySearch(
        problem=problem,
        robot=gantry_arm(),
        backend=engine_of(problem),
        collision=FlatChecker(problem),
        arm_planner=Straight(),
        retrieval=StraightRetrieval(problem),
        actions=(("push", StraightPush(problem)),),
        verifier=lambda plan: replayed(problem, plan),
        options=MySearchOptions(**options),
    )
    return search.solve(Budget(seconds), np.random.default_rng(seed), lambda text: None)


@pytest.mark.parametrize("scene", [clear_scene(), one_blocker(), two_blockers()])
def test_it_moves_what_is_in_the_way_and_nothing_else(scene: TinyScene) -> None:
    solution = solved(scene)
    assert solution.status is SolutionStatus.SOLVED
    assert solution.plan is not None
    assert {action.object_name for action in solution.plan.actions} == set(scene.blockers)
    assert replayed(scene.problem, solution.plan).ok


def test_it_says_why_it_finds_nothing() -> None:
    solution = solved(walled_in(), attempts=2)
    assert (solution.status, solution.plan) == (SolutionStatus.BUDGET_EXHAUSTED, None)
    assert solution.reason == "nothing is left to try"
    assert solution.statistics.causes == {"target/retrieval/blocked_by_w": 2}


def test_plans_are_no_longer_than_allowed() -> None:
    assert solved(two_blockers(), depth=1, attempts=2).plan is None


def test_the_budget_ends_it() -> None:
    assert solved(one_blocker(), seconds=0.0).reason == "no plan within the budget"


def test_the_same_seed_gives_the_same_plan() -> None:
    first, second = (solved(two_blockers(), seed=5).plan for _ in range(2))
    assert first is not None
    assert second is not None
    for one, other in zip(first.motions, second.motions, strict=True):
        for a, b in zip(one.segments, other.segments, strict=True):
            assert np.array_equal(a.trajectory.positions, b.trajectory.positions)
