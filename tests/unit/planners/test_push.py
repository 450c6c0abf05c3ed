"""Pushes: where the hand may stand, how it gets there, and what is counted when it cannot."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from mamo_planners.actions.push import Push
from mamo_planners.actions.push_geometry import (
    ToolPose,
    ToolPoses,
    awkwardness,
    rich_tool_poses,
    thesis_tool_poses,
)
from mamo_planners.options import PushOptions

from mamo_core.interfaces.action_generator import ActionRequest
from mamo_core.robots.exact_collision import ExactChecker
from mamo_core.robots.timing import interpolated
from mamo_core.types.geometry import Cylinder, tool_matrix
from mamo_core.types.motion import SegmentKind
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility, SceneState
from mamo_core.types.solution import Statistics

ASIDE = (Cylinder(0.03, 0.16), Mobility.TARGET, (0.7, -0.75))
REGION = SweptRegion(np.zeros(2), 0.1, np.full((2, 2), np.inf), 0.77)


def push_of(problem, parts, **options):
    return Push(
        problem,
        parts.arm,
        parts.kinematics,
        parts.collision,
        parts.arm_planner,
        PushOptions(**options),
    )


def request(problem, name="blocker", move=(0.12, 0.0)):
    start = problem.initial.object_poses[problem.scene.index(name), :2]
    return ActionRequest(name, start + np.linspace(0, 1, 13)[:, None] * np.array(move), REGION)


def proposals(problem, parts, order, seed=0, **options):
    statistics = Statistics()
    generator = push_of(problem, parts, **options)
    rng = np.random.default_rng(seed)
    return list(generator.propose(problem.initial, order, rng, statistics)), statistics


@pytest.mark.parametrize(("longest", "length"), [(None, 0.12), (0.2, 0.12), (0.05, 0.05)])
def test_the_longest_push(problem, parts, longest, length):
    (action, *_), _ = proposals(problem, parts, request(problem), longest=longest)
    way = action.path[-1] - action.path[0]
    assert way == pytest.approx([length, 0.0])


def the_same(action, move=(0.12, 0.0), name="blocker", **info):
    """The action with another end or another hand."""
    start = action.path[0]
    path = np.stack([start, start + np.array(move)])
    return replace(action, object_name=name, path=path, info={**action.info, **info})


def test_pushes_that_go_where_one_failed_with_the_same_hand_are_alike(problem, parts):
    push = push_of(problem, parts, alike=0.015)
    (action, *_), _ = proposals(problem, parts, request(problem))
    failed = the_same(action, yaw=3.1, pitch=0.1)

    def like(**changes):
        return push.alike(the_same(failed, **changes), failed)

    assert like()
    assert like(move=(0.13, 0.0))
    assert like(move=(0.3, 0.02))  # it comes by there
    assert not like(move=(0.1, 0.0))
    assert not like(move=(0.3, 0.1))
    assert like(yaw=-3.1)  # across the cut
    assert not like(yaw=2.7)
    assert not like(pitch=0.52)
    assert not like(name="target")
    assert not push_of(problem, parts).alike(failed, failed)


@pytest.fixture(scope="module")
def problem(shelf_with):
    """The target stands aside, so that there is room behind the blocker."""
    return shelf_with({"target": ASIDE})


@pytest.fixture(scope="module")
def parts(problem, parts_of):
    return parts_of(problem)


@pytest.fixture(scope="module")
def pushes(problem, parts):
    found, statistics = proposals(problem, parts, request(problem))
    assert found, statistics.causes
    return found


def test_every_tool_stands_behind_and_low():
    """Each of the rich poses: where it is, how it is turned, and how low its hand gets."""
    rng = np.random.default_rng(0)
    hand = np.column_stack([rng.uniform(-0.1, 0.1, (20, 3)), rng.uniform(0.01, 0.03, 20)])
    poses = rich_tool_poses()
    for _ in range(5):
        angle, position, extent = rng.uniform(-3, 3), rng.uniform(-1, 1, 2), rng.uniform(0, 0.1)
        direction = np.array([np.cos(angle), np.sin(angle)])
        tools = ToolPoses(poses, hand, 0.7, 0.004).behind(position, direction, extent)
        for pose, T in zip(poses, tools, strict=True):
            yaw = angle + pose.yaw_offset
            behind = position - direction * (extent + pose.stand_off)
            tip = behind + pose.overreach * np.array([np.cos(yaw), np.sin(yaw)])
            expected = tool_matrix([*tip, T[2, 3]], yaw, pose.pitch)
            np.testing.assert_allclose(T, expected, atol=1e-12)
            lowest = (hand[:, :3] @ T[2, :3] + T[2, 3] - hand[:, 3]).min()
            assert lowest == pytest.approx(0.704)


def test_the_thesis_knows_one_pose():
    found = thesis_tool_poses(np.random.default_rng(0))
    assert len(found) == 1
    assert (found[0].yaw_offset, found[0].overreach) == (0.0, 0.0)
    assert found[0].pitch == pytest.approx(np.radians(30.0))
    draws = [thesis_tool_poses(np.random.default_rng(k))[0].stand_off for k in range(400)]
    assert min(draws) >= 0.0
    assert np.mean(draws) == pytest.approx(0.05, abs=0.005)
    assert np.std(draws) == pytest.approx(0.025, abs=0.005)


def test_the_rich_set():
    """All combinations, each once; at least seven yaws, two pitches, three stand-offs."""
    poses = rich_tool_poses()
    assert len(set(poses)) == len(poses)
    yaws, pitches, gaps = (
        {getattr(pose, field) for pose in poses} for field in ("yaw_offset", "pitch", "stand_off")
    )
    assert len(yaws) >= 7
    assert len(pitches) >= 2
    assert len(gaps) >= 3
    assert {(p.yaw_offset, p.pitch, p.stand_off) for p in poses} == {
        (y, p, g) for y in yaws for p in pitches for g in gaps
    }
    assert all((-y in yaws) for y in yaws)
    assert all(0.0 < g <= 0.1 for g in gaps)


def test_pushes_along_the_hand_come_first():
    assert awkwardness(ToolPose(0.0, 0.52, 0.03)) < awkwardness(ToolPose(1.1, 0.52, 0.03))
    assert awkwardness(ToolPose(0.0, 0.52, 0.03)) < awkwardness(ToolPose(0.0, 0.52, 0.1))


def test_what_a_push_is(problem, parts, pushes):
    for action in pushes:
        assert (action.kind, action.object_name) == ("push", "blocker")
        motion = action.motion
        assert [s.kind.value for s in motion.segments] == ["transit", "sweep", "retract"]
        assert [s.held for s in motion.segments] == [None] * 3
        assert motion.segments[0].contact_free
        assert not motion.segments[1].contact_free
        assert {s.opening for s in motion.segments} == {parts.arm.gripper.closed}
        assert np.array_equal(motion.start, problem.home)
        sweep, retract = motion.segments[1], motion.segments[2]
        np.testing.assert_allclose(motion.end, sweep.trajectory.positions[0], atol=1e-9)
        np.testing.assert_allclose(
            retract.trajectory.positions[0], sweep.trajectory.positions[-1], atol=1e-9
        )
        assert motion.segments[1].settle > 0.0


def test_at_most_so_many_samples(problem, parts):
    found, _ = proposals(problem, parts, request(problem), samples=2)
    assert len(found) == 2


def test_the_approach_is_contact_free(problem, parts, pushes):
    """With exact meshes, among all objects."""
    world = ExactChecker(problem.scene, parts.arm).world(
        problem.initial.object_poses, opening=parts.arm.gripper.closed
    )
    for action in pushes[:4]:
        for q in interpolated(action.motion.segments[0].trajectory.positions, 0.05):
            assert world.first_touched(q) is None


def test_the_sweep_touches_nothing_that_is_fixed(problem, parts, pushes):
    movables = ["blocker", "beside"]
    world = ExactChecker(problem.scene, parts.arm).world(
        problem.initial.object_poses, opening=parts.arm.gripper.closed, ignore=movables
    )
    for action in pushes[:4]:
        for q in interpolated(action.motion.segments[1].trajectory.positions, 0.05):
            assert world.first_touched(q) is None


def test_the_sweep_is_straight_level_and_slow(problem, parts, pushes):
    for action in pushes:
        t = action.motion.segments[1].trajectory
        tools = np.array([parts.kinematics.forward(q)[:3, 3] for q in t.positions])
        along = tools[-1] - tools[0]
        direction = along / np.linalg.norm(along)
        assert direction[0] == pytest.approx(1.0, abs=1e-3)
        off = (tools - tools[0]) - ((tools - tools[0]) @ direction)[:, None] * direction
        assert np.linalg.norm(off, axis=1).max() < 1.5e-3
        speeds = np.linalg.norm(np.diff(tools, axis=0), axis=1) / np.diff(t.times)
        assert speeds.max() < 0.25 * 1.05
        # The object's 12 cm, the gap before it, and a little more.
        assert 0.12 + 0.03 < np.linalg.norm(along) < 0.12 + 0.1 + 0.02


def test_the_goal_is_the_end_of_the_path(problem, pushes):
    start = problem.initial.object_poses[0, :2]
    for action in pushes:
        expected = start + np.array([[0.0, 0.0], [0.12, 0.0]])
        np.testing.assert_allclose(action.path, expected, atol=1e-12)


def test_same_seed_same_pushes(problem, parts):
    one, other = (proposals(problem, parts, request(problem), seed=4)[0] for _ in range(2))
    assert len(one) == len(other)
    for a, b in zip(one, other, strict=True):
        assert a.info == b.info
        for s, t in zip(a.motion.segments, b.motion.segments, strict=True):
            assert np.array_equal(s.trajectory.positions, t.trajectory.positions)


def test_the_goal_is_truncated_before_an_immovable(shelf_with, parts_of):
    """A post right behind: the box may slide 5 cm, not 12."""
    post = (Cylinder(0.03, 0.2), Mobility.IMMOVABLE, (0.58 + 0.035 + 0.03 + 0.055, -0.5))
    problem = shelf_with({"post": post, "target": ASIDE})
    found, _ = proposals(problem, parts_of(problem), request(problem))
    assert found
    for action in found:
        assert action.path[-1][0] - action.path[0][0] == pytest.approx(0.05, abs=1e-9)


def test_the_thesis_does_not_truncate(shelf_with, parts_of):
    post = (Cylinder(0.03, 0.2), Mobility.IMMOVABLE, (0.7, -0.5))
    problem = shelf_with({"post": post, "target": ASIDE})
    generator = push_of(problem, parts_of(problem), geometry="thesis")
    order = request(problem)
    shape, pose = problem.scene.objects[0].shape, problem.initial.object_poses[0]
    delta = generator._displacement(shape, pose, order, np.random.default_rng(0))
    np.testing.assert_allclose(delta, [0.12, 0.0])


def test_without_room_there_is_no_push(shelf_with, parts_of):
    post = (Cylinder(0.03, 0.2), Mobility.IMMOVABLE, (0.58 + 0.035 + 0.03 + 0.005, -0.5))
    problem = shelf_with({"post": post, "target": ASIDE})
    found, statistics = proposals(problem, parts_of(problem), request(problem))
    assert found == []
    assert statistics.causes == {"blocker/push/no_room": 1}


def test_every_failure_has_a_cause(problem, parts):
    """For an object in the far corner; whatever fails is counted under its name."""
    order = request(problem, "beside", (-0.1, 0.1))
    found, statistics = proposals(problem, parts, order)
    causes = {key: times for key, times in statistics.causes.items() if times}
    assert causes or found
    known = {
        "no_room",
        "hand_blocked",
        "no_ik",
        "start_blocked",
        "line_untrackable",
        "sweep_blocked",
        "approach_exhausted",
        "approach_goals_blocked",
        "approach_start_blocked",
    }
    for key in causes:
        subject, action, cause = key.split("/")
        assert (subject, action) == ("beside", "push")
        assert cause in known


def test_a_surrounded_object_says_that_the_hand_does_not_fit(shelf_with, parts_of):
    """Posts on three sides, no room for the hand before it."""
    ring = {
        f"p{k}": (Cylinder(0.02, 0.2), Mobility.IMMOVABLE, (0.58 + x, -0.5 + y))
        for k, (x, y) in enumerate(
            [(-0.1, 0.0), (-0.1, 0.06), (-0.1, -0.06), (-0.08, 0.11), (-0.08, -0.11)]
        )
    }
    problem = shelf_with({**ring, "target": ASIDE})
    found, statistics = proposals(problem, parts_of(problem), request(problem, move=(0.2, 0.0)))
    assert found == []
    assert statistics.causes["blocker/push/hand_blocked"] == 1


def test_a_blocked_start_of_the_arm(problem, parts):
    """An object around the hand at home: no approach starts there."""
    poses = np.array(problem.initial.object_poses)
    poses[1, :3] = parts.kinematics.forward(problem.home)[:3, 3]
    state = SceneState(problem.home, poses)
    statistics = Statistics()
    order = request(problem)
    found = list(
        push_of(problem, parts).propose(state, order, np.random.default_rng(0), statistics)
    )
    assert found == []
    assert statistics.causes["blocker/push/approach_start_blocked"] >= 1


def test_goal_agnostic_pushes_stay_in_the_shelf(problem, parts):
    """In any direction, six to twenty-five centimetres, cut where it ends."""
    lower = problem.scene.workspace.lower[:2] - [problem.scene.workspace.overhang, 0.0]
    upper = problem.scene.workspace.upper[:2]
    angles = []
    for seed in range(6):
        order = ActionRequest("blocker", None, REGION)
        found, _ = proposals(problem, parts, order, seed=seed, samples=1)
        for action in found:
            delta = action.path[-1] - action.path[0]
            angles.append(np.arctan2(delta[1], delta[0]))
            assert 0.02 <= np.linalg.norm(delta) <= 0.25
            assert (action.path[-1] - [0.035, 0.06] >= lower - 1e-9).all()
            assert (action.path[-1] + [0.035, 0.06] <= upper + 1e-9).all()
    assert len({round(angle, 3) for angle in angles}) >= 3


def test_proposals_are_made_when_asked_for(problem, parts):
    statistics = Statistics()
    generator = push_of(problem, parts).propose(
        problem.initial, request(problem), np.random.default_rng(0), statistics
    )
    assert statistics.counts["arm_plans"] == 0
    next(generator)
    first = statistics.counts["arm_plans"]
    next(generator)
    assert 1 <= first < statistics.counts["arm_plans"]


def test_the_hand_is_just_above_the_floor(problem, parts, pushes):
    """Low, but by the gap of the options clear of it."""
    floor = problem.scene.workspace.floor
    exact = ExactChecker(problem.scene, parts.arm)
    names = [o.name for o in problem.scene.objects]
    for action in pushes[:3]:
        q = action.motion.segments[1].trajectory.positions[0]
        assert exact.world(problem.initial.object_poses, opening=0.001, ignore=names).free(q)[0]
        height = parts.kinematics.forward(q)[2, 3] - floor
        assert 0.0 < height < 0.12


def test_kinds_of_segments_follow_each_other(pushes):
    for action in pushes:
        for before, after in pairwise(action.motion.segments):
            assert np.allclose(before.trajectory.positions[-1], after.trajectory.positions[0])
        assert action.motion.after_transit().segments[0].kind is SegmentKind.SWEEP
        assert replace(action).info == action.info
