"""Multi-heuristic A* as an arm planner, for the gantry."""

import numpy as np
import pytest
from mamo_planners.reaching.arm_planner import MultiHeuristicAStar
from mamo_planners.reaching.options import ArmLatticeOptions

from mamo_core.interfaces.arm_planner import ArmPlanStatus
from mamo_core.testing.flat_checker import FlatChecker
from mamo_core.testing.gantry import UprightGantry
from mamo_core.testing.gantry_arm import gantry_arm
from mamo_core.testing.scenes import HOME, one_blocker

BEYOND = np.array([0.36, 0.0, 0.05, 0.0])
"""Behind the object that stands in the way of the straight motion from home."""

INSIDE = np.array([0.25, 0.0, 0.05, 0.0])
"""Where that object is."""


@pytest.fixture
def world():
    problem = one_blocker().problem
    return FlatChecker(problem).world(problem.initial.object_poses, opening=0.0, ignore=["target"])


@pytest.fixture
def planner():
    # The gantry's steps are metres: 3.5 cm.
    options = ArmLatticeOptions(large_step_deg=2.0)
    return MultiHeuristicAStar(one_blocker().problem, gantry_arm(), UprightGantry(), options)


def planned(planner, world, goals, start=HOME, **limits):
    return planner.plan(start, np.array(goals), world, np.random.default_rng(0), **limits)


def test_a_path_around_an_object(planner, world):
    assert not world.edges_free(HOME[None], BEYOND[None])[0]
    plan = planned(planner, world, [INSIDE, BEYOND])
    assert (plan.status, plan.goal) == (ArmPlanStatus.SOLVED, 1)
    assert plan.path[0] == pytest.approx(HOME)
    assert plan.path[-1] == pytest.approx(BEYOND)
    assert world.edges_free(plan.path[:-1], plan.path[1:]).all()


def test_the_same_query_gives_the_same_path(planner, world):
    one, two = (planned(planner, world, [BEYOND]) for _ in range(2))
    assert np.array_equal(one.path, two.path)
    assert one.checks == two.checks


def test_a_free_straight_motion_is_taken(planner, world):
    plan = planned(planner, world, [HOME + np.array([0.1, 0.0, 0.0, 0.0])])
    assert len(plan.path) == 2


@pytest.mark.parametrize(
    ("start", "goals", "status", "checks"),
    [
        (INSIDE, [BEYOND], ArmPlanStatus.START_BLOCKED, 1),
        (HOME, [INSIDE], ArmPlanStatus.GOALS_BLOCKED, 2),
        (HOME, np.zeros((0, 4)), ArmPlanStatus.GOALS_BLOCKED, 1),
    ],
)
def test_what_is_blocked(planner, world, start, goals, status, checks):
    plan = planned(planner, world, goals, start)
    assert (plan.status, plan.path, plan.checks) == (status, None, checks)


def test_checks_are_limited(planner, world):
    plan = planned(planner, world, [BEYOND], max_checks=3)
    assert plan.status is ArmPlanStatus.EXHAUSTED
    assert plan.checks < 3 + 1 + 8
