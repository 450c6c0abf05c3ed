"""OMPL's planners keep the contract of arm planners: free paths, an honest status, repeatable."""

import gc
import weakref

import numpy as np
import pytest
from mamo_ompl.kinds import KINDS

from mamo_core.interfaces.arm_planner import ArmPlanStatus

NAMES = sorted(KINDS)


def rng(seed=0):
    return np.random.default_rng(seed)


def confirmed(world, path):
    """Free motion by motion, forwards or backwards: either answer of a checker is sound."""
    forwards = world.edges_free(path[:-1], path[1:])
    return (forwards | world.edges_free(path[1:], path[:-1])).all()


@pytest.mark.parametrize("name", NAMES)
def test_paths_are_free_from_the_start_to_a_goal(planner, name, arm, world, hard_goals):
    solved = 0
    for k in range(6):
        pair = hard_goals[k : k + 2]
        plan = planner(name).plan(arm.home, pair, world, rng(k))
        if plan.status is not ArmPlanStatus.SOLVED:
            assert (plan.status, plan.path, plan.goal) == (ArmPlanStatus.EXHAUSTED, None, -1)
            continue
        solved += 1
        assert np.array_equal(plan.path[0], arm.home)
        np.testing.assert_allclose(plan.path[-1], pair[plan.goal], atol=1e-8)
        assert plan.checks > 0
        assert confirmed(world, plan.path)
    assert solved >= 3


@pytest.mark.parametrize("name", NAMES)
def test_same_seed_same_path_whatever_ran_before(planner, name, arm, world, hard_goals):
    """OMPL has one seed for the process, and says that it can be set but once."""

    def plan(seed, name=name):
        return planner(name).plan(arm.home, hard_goals[:3], world, rng(seed))

    first, other = plan(5), plan(6)
    plan(1, "ompl_rrt")
    again = plan(5)
    assert first.path is not None
    assert np.array_equal(first.path, again.path)
    assert (first.goal, first.checks) == (again.goal, again.checks)
    assert first.checks != other.checks


@pytest.mark.parametrize("name", NAMES)
def test_a_wall_is_gone_around(planner, name, across, wall):
    """Any checker will do."""
    start, goal = across
    plan = planner(name).plan(start, goal[None], wall(), rng())
    assert plan.status is ArmPlanStatus.SOLVED
    assert plan.path[:, 1].max() > 0.2
    assert confirmed(wall(), plan.path)


def test_the_goal_is_numbered_among_all_goals(planner, arm, world, hard_goals, reaching):
    blocked = reaching[~world.free(reaching)][:3]
    mixed = np.vstack([blocked, hard_goals[:1]])
    plan = planner().plan(arm.home, mixed, world, rng())
    assert (plan.status, plan.goal) == (ArmPlanStatus.SOLVED, 3)
    np.testing.assert_allclose(plan.path[-1], mixed[3], atol=1e-8)


def test_start_blocked(planner, arm, world, goals, reaching):
    blocked = reaching[~world.free(reaching)][0]
    plan = planner().plan(blocked, goals[:2], world, rng())
    assert (plan.status, plan.path, plan.goal) == (ArmPlanStatus.START_BLOCKED, None, -1)


def test_goals_blocked(planner, arm, world, reaching):
    blocked = reaching[~world.free(reaching)][:4]
    plan = planner().plan(arm.home, blocked, world, rng())
    assert (plan.status, plan.path, plan.goal) == (ArmPlanStatus.GOALS_BLOCKED, None, -1)
    none = planner().plan(arm.home, np.zeros((0, 7)), world, rng())
    assert none.status is ArmPlanStatus.GOALS_BLOCKED


@pytest.mark.parametrize("name", NAMES)
def test_work_is_limited(planner, name, across, wall):
    """No way at all: joint 0 cannot pass. One motion may be under way when the checks run out."""
    start, goal = across
    world = wall(top=np.inf)
    plan = planner(name).plan(start, goal[None], world, rng(), max_checks=500)
    assert (plan.status, plan.path) == (ArmPlanStatus.EXHAUSTED, None)
    assert plan.checks < 600
    if name not in ("ompl_fmt", "ompl_bfmt"):  # a batch may be done with earlier
        assert plan.checks >= 500
    short = planner(name, max_checks=500).plan(start, goal[None], wall(top=np.inf), rng())
    assert (short.status, short.checks) == (plan.status, plan.checks)


def test_start_at_the_goal(planner, arm, world):
    plan = planner().plan(arm.home, arm.home[None], world, rng())
    assert plan.status is ArmPlanStatus.SOLVED
    assert plan.path.shape == (1, arm.dof)


def test_a_straight_way_is_taken(planner, arm, world):
    goal = arm.home + 0.05
    plan = planner().plan(arm.home, goal[None], world, rng())
    np.testing.assert_allclose(plan.path, [arm.home, goal])


def test_starts_beyond_the_usual_bounds(planner, arm, wall):
    """OMPL refuses a start out of bounds; continuous joints may be anywhere."""
    start, goal = arm.home.copy(), arm.home.copy()
    start[4] += 4.0
    goal[4] -= 4.0
    assert planner().plan(start, goal[None], wall(), rng()).status is ArmPlanStatus.SOLVED


def test_shortcuts_never_lengthen(planner, arm, world, hard_goals):
    def length(tries, k):
        made = planner("ompl_kpiece", shortcuts=tries)
        path = made.plan(arm.home, hard_goals[k : k + 1], world, rng(k)).path
        return None if path is None else np.linalg.norm(np.diff(path, axis=0), axis=1).sum()

    pairs = [(length(0, k), length(60, k)) for k in range(8)]
    pairs = [pair for pair in pairs if pair[0] is not None]
    assert len(pairs) >= 4
    assert all(smooth <= rough + 1e-9 for rough, smooth in pairs)
    assert any(smooth < 0.9 * rough for rough, smooth in pairs)


def test_optimizing_uses_up_the_checks(planner, arm, world, hard_goals):
    def plan(optimize):
        made = planner("ompl_rrt_star", optimize=optimize, shortcuts=0)
        return made.plan(arm.home, hard_goals[:2], world, rng(1), max_checks=8000)

    first, best = plan(False), plan(True)
    assert first.checks < 8000 <= best.checks
    lengths = [np.linalg.norm(np.diff(p.path, axis=0), axis=1).sum() for p in (first, best)]
    assert lengths[1] <= lengths[0]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("method", ["free", "edges_free"])
def test_errors_of_the_checker_arrive(planner, name, method, across, wall):
    """They do not get lost in OMPL, and end the solve at once."""
    world, asked = wall(), []

    def broken(*configurations):
        asked.append(1)
        if len(asked) > 5:
            raise ZeroDivisionError("the checker broke")
        return getattr(wall, method)(world, *configurations)

    setattr(world, method, broken)
    start, goal = across
    caught = None
    try:
        planner(name, shortcuts=200).plan(start, goal[None], world, rng())
    except ZeroDivisionError as error:
        caught = error
    assert len(asked) == 6 if caught else len(asked) <= 5, "the error got lost"


@pytest.mark.parametrize("broken", [False, True])
def test_nothing_outlives_a_query(planner, across, wall, broken):
    """Cycles through OMPL's objects are invisible to Python's garbage collection."""
    world = wall()
    seen = weakref.ref(world)
    start, goal = across
    if broken:
        world.edges_free = lambda starts, ends: 1 / 0
        with pytest.raises(ZeroDivisionError):
            planner().plan(start, goal[None], world, rng())
    else:
        planner().plan(start, goal[None], world, rng())
    del world
    gc.collect()
    assert seen() is None
