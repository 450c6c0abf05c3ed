"""Plans for the task to reach: the verifier accepts a real one and refuses each broken kind."""

from dataclasses import replace

import numpy as np
import pytest

from mamo_core.choices import choose
from mamo_core.classify import REACH_ROLES, class_of, make_classifier
from mamo_core.compose import build_parts
from mamo_core.errors import InputError
from mamo_core.plugins import discover
from mamo_core.recipes import find_recipe, load_recipe
from mamo_core.robots.timing import gripper_seconds, time_path
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.problem import Task
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Plan
from mamo_core.verify import verify

BLOCKER, TARGET = 0, 3
"""Places of the objects in the small shelf."""

APART = {BLOCKER: (0.75, -0.7), TARGET: (0.7, -0.5)}
"""The blocker beside the way to the target, m."""


def moved(problem, places):
    poses = np.array(problem.initial.object_poses)
    for place, xy in places.items():
        poses[place, :2] = xy
    return replace(problem, initial=SceneState(problem.home, poses))


@pytest.fixture(scope="module")
def reach(problem):
    """The small shelf with one pre-grasp to reach, straight from the front, and nothing before."""
    return replace(moved(problem, APART), task=Task.REACH, grasps=problem.grasps[:1])


def built(problem):
    roles = ("constraint", "backend", *REACH_ROLES)
    recipe = load_recipe(find_recipe("m4m"))
    return build_parts(choose(recipe, problem, discover(), roles), problem)


@pytest.fixture(scope="module")
def parts(reach):
    return built(reach)


@pytest.fixture(scope="module")
def plan(reach, parts):
    return plan_to(parts, reach.pregrasps[0], reach.grasps[0].opening)


@pytest.fixture(scope="module")
def report_of(reach, parts):
    return lambda plan: verify(reach, plan, parts.backend, parts.robot)


def plan_to(parts, T_world_tool, opening):
    rng = np.random.default_rng(0)
    home = parts.problem.home
    world = parts.collision.world(parts.problem.initial.object_poses, opening=opening)
    goals = parts.kinematics.inverse(T_world_tool, rng, count=16)
    path = parts.arm_planner.plan(home, goals[world.free(goals)], world, rng).path
    gripper = parts.robot.gripper
    still = Trajectory.still(home, gripper_seconds(gripper, gripper.closed, opening))
    timed = time_path(path, parts.robot.limits, scale=0.5)
    segments = (
        MotionSegment(SegmentKind.GRIPPER, still, opening, contact_free=True),
        MotionSegment(SegmentKind.TRANSIT, timed, opening, contact_free=True),
    )
    return Plan((), Motion(segments, parts.robot.gripper.closed))


def with_segments(plan, **changes):
    segments = tuple(replace(s, **changes) for s in plan.retrieval.segments)
    return replace(plan, retrieval=replace(plan.retrieval, segments=segments))


def test_the_plan_holds(plan, report_of):
    report = report_of(plan)
    assert report.failures == ()
    assert report.ok


def test_the_hand_elsewhere(reach, parts, report_of):
    aside = reach.pregrasps[0].copy()
    aside[1, 3] += 0.02
    report = report_of(plan_to(parts, aside, reach.grasps[0].opening))
    assert report.kinds == ("not_reached",)
    (failure,) = report.failures
    assert failure == "the hand does not end, open, where the approach of a grasp begins"


def test_the_hand_turned(reach, parts, report_of):
    turned = reach.pregrasps[0].copy()
    turned[:3, 1:3] *= -1.0  # half a turn about where it points
    assert report_of(plan_to(parts, turned, reach.grasps[0].opening)).kinds == ("not_reached",)


def test_the_hand_not_open_enough(reach, plan, report_of):
    report = report_of(with_segments(plan, opening=reach.grasps[0].opening - 0.005))
    assert report.kinds == ("not_reached",)


def test_an_object_in_the_hand(plan, report_of):
    report = report_of(with_segments(plan, held="target"))
    assert report.kinds == ("form",)
    assert report.failures == ("the reach holds an object",)


def test_an_object_on_the_way(problem, plan, parts):
    """The rules hold on the way to a pre-grasp, too."""
    blocked = replace(moved(problem, {}), task=Task.REACH, grasps=problem.grasps[:1])
    report = verify(blocked, plan, built(blocked).backend, parts.robot)
    assert not report.ok
    assert "not_reached" not in report.kinds


def test_searches_for_another_task_are_refused(reach, compose_for):
    message = (
        r"m4m.yaml:\d+:\d+: search 'greedy' does not plan for the task 'reach' of problem 'small' "
        r"\(it does for: retrieve\)"
    )
    with pytest.raises(InputError, match=message):
        compose_for(reach)


@pytest.fixture(scope="module")
def classify():
    return make_classifier(load_recipe(find_recipe("default")), discover())


def with_post_at_a_finger(reach):
    x, y, _ = reach.pregrasps[0][:3, 3]
    return moved(reach, {reach.scene.index("post"): (x, y + 0.05)})


def test_class_by_what_is_on_the_way(problem, reach, classify):
    before = replace(moved(problem, {}), task=Task.REACH, grasps=problem.grasps[:1])
    assert classify(reach) == 0
    assert [classify(before) for _ in range(2)] == [1, 1]
    assert [class_of(n) for n in (None, 0, 1, 2, 3)] == [
        "unreachable",
        "none",
        "easy",
        "medium",
        "hard",
    ]


def test_a_pre_grasp_where_an_immovable_stands_is_out_of_reach(reach, classify):
    assert classify(with_post_at_a_finger(reach)) is None


def test_a_reach_is_classified_without_a_retrieval_planner(reach):
    located = find_recipe("default").without("retrieval")
    assert make_classifier(load_recipe(located), discover())(reach) == 0


def test_any_of_several_pre_grasps_will_do(problem, reach, classify):
    several = replace(reach, grasps=(problem.grasps[0], problem.grasps[3]))
    assert classify(with_post_at_a_finger(several)) is not None
