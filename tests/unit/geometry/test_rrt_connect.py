"""The arm planner: free paths to one of several goals, and an honest status."""

import numpy as np
import pytest
from mamo_geometry.options import RRTConnectOptions
from mamo_geometry.rrt_connect import RRTConnect

from mamo_core.interfaces.arm_planner import ArmPlanStatus
from mamo_core.robots.timing import interpolated


@pytest.fixture(scope="module")
def world(shelf, checker):
    return checker.world(shelf.initial.object_poses, opening=0.0)


@pytest.fixture(scope="module")
def goals(world, reaching):
    """In the shelf, free."""
    found = reaching[world.free(reaching)]
    assert len(found) >= 30
    return found


def planner(arm, **options):
    return RRTConnect(arm, RRTConnectOptions(**options))


def length(checker, path):
    """As the planner measures it: joints weigh as far as the tool can be from them."""
    return np.linalg.norm(np.diff(path, axis=0) * checker._chain.reach, axis=1).sum()


def test_paths_are_free_from_the_start_to_the_goal(arm, world, goals, exact, shelf):
    authority = exact.world(shelf.initial.object_poses, opening=0.0)
    solved = 0
    for k in range(0, 24, 2):
        plan = planner(arm).plan(arm.home, goals[k : k + 2], world, np.random.default_rng(k))
        if plan.status is not ArmPlanStatus.SOLVED:
            continue
        solved += 1
        assert np.array_equal(plan.path[0], arm.home)
        np.testing.assert_allclose(plan.path[-1], goals[k + plan.goal], atol=1e-8)
        assert plan.goal in (0, 1)
        assert plan.checks > 0
        assert world.edges_free(plan.path[:-1], plan.path[1:]).all()
        assert authority.edges_free(plan.path[:-1], plan.path[1:]).all()
    assert solved >= 10


def test_same_seed_same_path(arm, world, goals):
    def plan(seed):
        return planner(arm).plan(arm.home, goals[:3], world, np.random.default_rng(seed))

    first, again, other = plan(5), plan(5), plan(6)
    assert np.array_equal(first.path, again.path)
    assert (first.goal, first.checks) == (again.goal, again.checks)
    assert first.path.shape != other.path.shape or not np.array_equal(first.path, other.path)


def test_the_goal_is_numbered_among_all_goals(arm, world, goals, reaching):
    blocked = reaching[~world.free(reaching)][:3]
    mixed = np.vstack([blocked, goals[:1]])
    plan = planner(arm).plan(arm.home, mixed, world, np.random.default_rng(0))
    assert plan.status is ArmPlanStatus.SOLVED
    assert plan.goal == 3
    np.testing.assert_allclose(plan.path[-1], goals[0], atol=1e-8)


def test_start_blocked(arm, world, goals, reaching):
    blocked = reaching[~world.free(reaching)][0]
    plan = planner(arm).plan(blocked, goals[:2], world, np.random.default_rng(0))
    assert (plan.status, plan.path, plan.goal) == (ArmPlanStatus.START_BLOCKED, None, -1)


def test_goals_blocked(arm, world, reaching):
    blocked = reaching[~world.free(reaching)][:4]
    plan = planner(arm).plan(arm.home, blocked, world, np.random.default_rng(0))
    assert (plan.status, plan.path, plan.goal) == (ArmPlanStatus.GOALS_BLOCKED, None, -1)
    none = planner(arm).plan(arm.home, np.zeros((0, 7)), world, np.random.default_rng(0))
    assert none.status is ArmPlanStatus.GOALS_BLOCKED


def hard_goals(arm, world, goals):
    """Those that the straight line does not reach."""
    starts = np.repeat(arm.home[None], len(goals), axis=0)
    return goals[~world.edges_free(starts, goals)]


def test_exhausted_within_the_checks(arm, world, goals):
    goal = hard_goals(arm, world, goals)[:1]
    plan = planner(arm).plan(arm.home, goal, world, np.random.default_rng(0), max_checks=20)
    assert (plan.status, plan.path) == (ArmPlanStatus.EXHAUSTED, None)
    # One edge may be under way when the checks run out.
    assert 20 <= plan.checks < 200
    short = planner(arm, max_checks=20).plan(arm.home, goal, world, np.random.default_rng(0))
    assert short.status is ArmPlanStatus.EXHAUSTED


def test_start_at_the_goal(arm, world):
    plan = planner(arm).plan(arm.home, arm.home[None], world, np.random.default_rng(0))
    assert plan.status is ArmPlanStatus.SOLVED
    assert plan.path.shape == (1, arm.dof)


def test_a_straight_way_is_taken(arm, world):
    goal = arm.home + 0.05
    plan = planner(arm).plan(arm.home, goal[None], world, np.random.default_rng(0))
    np.testing.assert_allclose(plan.path[[0, -1]], [arm.home, goal])
    straight = np.linalg.norm(goal - arm.home)
    assert np.linalg.norm(np.diff(plan.path, axis=0), axis=1).sum() == pytest.approx(straight)


def test_ways_around_are_free(arm, world, goals, exact, shelf):
    """Shortcuts and all: where the straight line is blocked."""
    authority = exact.world(shelf.initial.object_poses, opening=0.0)
    solved = 0
    for k, goal in enumerate(hard_goals(arm, world, goals)[:12]):
        plan = planner(arm).plan(arm.home, goal[None], world, np.random.default_rng(k))
        if plan.status is ArmPlanStatus.SOLVED:
            solved += 1
            assert len(plan.path) > 2
            assert world.free(interpolated(plan.path, 0.05)).mean() > 0.98
            assert authority.edges_free(plan.path[:-1], plan.path[1:]).all()
    assert solved >= 4


def test_shortcuts_never_lengthen(arm, checker, world, goals):
    shorter = 0
    hard = hard_goals(arm, world, goals)
    for k in range(10):
        plans = [
            planner(arm, shortcuts=n).plan(
                arm.home, hard[k : k + 1], world, np.random.default_rng(k)
            )
            for n in (0, 60)
        ]
        if plans[0].path is None:
            continue
        rough, smooth = (length(checker, plan.path) for plan in plans)
        assert smooth <= rough + 1e-9
        shorter += smooth < 0.95 * rough
        np.testing.assert_allclose(plans[0].path[-1], plans[1].path[-1], atol=1e-8)
    assert shorter >= 3


def test_other_worlds_are_refused(arm, exact, shelf, goals):
    other = exact.world(shelf.initial.object_poses, opening=0.0)
    with pytest.raises(TypeError, match="worlds of 'spheres', not ExactWorld"):
        planner(arm).plan(arm.home, goals[:1], other, np.random.default_rng(0))
