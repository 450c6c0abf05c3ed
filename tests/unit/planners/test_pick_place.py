"""Pick and place: what is proposed, where the object ends, and what is refused with which cause."""

from dataclasses import replace
from itertools import islice, pairwise

import numpy as np
import pytest
from mamo_planners.actions.pick_place import PickPlace
from mamo_planners.options import PickPlaceOptions

from mamo_core.choices import choose
from mamo_core.compose import build_parts
from mamo_core.interfaces.action_generator import ActionRequest
from mamo_core.plugins import discover
from mamo_core.recipe_sets import chosen_recipe
from mamo_core.robots.contact_free import check_meshes
from mamo_core.robots.exact_collision import ExactChecker
from mamo_core.types.geometry import (
    Box,
    Cylinder,
    matrix_from_pose,
    pose_from_matrix,
    tool_matrix,
    yaw_of,
    z_axes,
)
from mamo_core.types.motion import SegmentKind
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility, SceneState
from mamo_core.types.solution import Statistics
from mamo_core.verify_grasp import check_fingers

THINGS = {
    "target": (Cylinder(0.03, 0.16), Mobility.TARGET, (0.85, -0.2)),
    "post": (Cylinder(0.03, 0.2), Mobility.IMMOVABLE, (0.95, -0.85)),
    "blocker": (Box(np.array([0.07, 0.06, 0.2])), Mobility.MOVABLE, (0.62, -0.45)),
    "can": (Cylinder(0.035, 0.16), Mobility.MOVABLE, (0.62, -0.7)),
    "beside": (Box(np.array([0.12, 0.1, 0.2])), Mobility.MOVABLE, (0.9, -0.55)),
}
GOAL = (0.66, -0.3)
ROLES = ("constraint", "backend", "kinematics", "collision", "arm_planner")


def region(blocked):
    """Swept to the floor where ``blocked(x, y)``, 1 cm cells over the shelf."""
    x, y = np.meshgrid(np.arange(0.4, 1.2, 0.01), np.arange(-1.0, 0.0, 0.01), indexing="ij")
    lowest = np.where(blocked(x, y), 0.77, np.inf)
    return SweptRegion(np.array([0.4, -1.0]), 0.01, lowest, 0.77)


NOWHERE = region(lambda x, y: np.zeros_like(x, dtype=bool))
LEFT = region(lambda x, y: y > -0.5)


@pytest.fixture(scope="module")
def problem(shelf_with):
    return shelf_with(THINGS)


@pytest.fixture(scope="module")
def context(problem):
    return build_parts(choose(chosen_recipe("m4m", None, ()), problem, discover(), ROLES), problem)


def generator(context, **options):
    return PickPlace(
        context.problem,
        context.robot,
        context.kinematics,
        context.collision,
        context.arm_planner,
        PickPlaceOptions(**options),
    )


def asked(context, name, goal=GOAL, swept=NOWHERE):
    start = context.problem.initial.object_poses[context.problem.scene.index(name), :2]
    path = None if goal is None else start + np.linspace(0, 1, 9)[:, None] * (goal - start)
    return ActionRequest(name, path, swept)


def proposals(context, request, *, state=None, seed=0, count=1, **options):
    """The first ``count`` actions, and what was counted."""
    statistics = Statistics()
    found = generator(context, **options).propose(
        state or context.problem.initial, request, np.random.default_rng(seed), statistics
    )
    return list(islice(found, count)), statistics


def placed(context, name, **changes):
    """The initial state with the pose of an object changed: ``xy`` or ``tilt`` (rad)."""
    poses = np.array(context.problem.initial.object_poses)
    number = context.problem.scene.index(name)
    if "xy" in changes:
        poses[number, :2] = changes["xy"]
    T = matrix_from_pose(poses[number])
    T[:3, :3] = tool_matrix([0, 0, 0], 0.0, changes.get("tilt", 0.0))[:3, :3] @ T[:3, :3]
    poses[number] = pose_from_matrix(T)
    return SceneState(context.problem.initial.joint_positions, poses)


@pytest.fixture(scope="module", params=["blocker", "can"])
def executed(request, context):
    """Name, action and rollout of a pick and place with a goal."""
    found, statistics = proposals(context, asked(context, request.param))
    assert found, statistics.causes
    return (
        request.param,
        found[0],
        context.backend.rollout(context.problem.initial, found[0].motion),
    )


def test_the_object_ends_where_it_was_asked_to_be(context, executed):
    name, action, result = executed
    number = context.problem.scene.index(name)
    before, after = context.problem.initial.object_poses[number], result.final_state.object_poses
    assert result.valid, result.violations
    assert np.linalg.norm(after[number, :2] - GOAL) < 0.003
    assert z_axes(after[number : number + 1])[0, 2] > np.cos(np.radians(1.0))
    assert after[number, 2] == pytest.approx(before[2], abs=0.001)
    assert name == "can" or yaw_of(after[number]) == pytest.approx(yaw_of(before), abs=0.02)
    assert result.moved == (name,)
    assert np.array_equal(action.path[-1], GOAL)


def test_the_fingers_and_nothing_else_touch(context, executed):
    name, _, result = executed
    assert ("robot", name) in result.contacts
    assert ("robot", "target") not in result.contacts
    others = {frozenset(pair) for pair in result.contacts if name not in pair}
    assert not any("robot" in pair for pair in others)


def test_contact_free_segments_are_so_on_exact_meshes(context, executed):
    _, action, result = executed
    scene, robot = context.problem.scene, context.robot
    segments, states = action.motion.segments, result.segment_states
    assert check_meshes(scene, segments, states, robot, action.motion.opening) == []
    assert all(s.contact_free for s in segments)


def test_only_closing_and_letting_go_may_touch_the_object(executed):
    name, action, _ = executed
    held = [s.held == name for s in action.motion.segments]
    handled = [n for n, s in enumerate(action.motion.segments) if s.closes_on is not None]
    first, last = held.index(True), len(held) - 1 - held[::-1].index(True)
    assert handled == [first - 1, last + 1]
    for n in handled:
        segment = action.motion.segments[n]
        assert (segment.kind, segment.closes_on) == (SegmentKind.GRIPPER, name)
        assert np.ptp(segment.trajectory.positions, axis=0).max() == 0.0


def test_the_fingers_stay_as_wide_as_the_object_leaves_them(context, executed):
    name, action, _ = executed
    item = context.problem.scene.objects[context.problem.scene.index(name)]
    width = 2.0 * item.shape.radius if name == "can" else item.shape.size[1]
    holding = [s.opening for s in action.motion.segments if s.held == name]
    assert holding == pytest.approx([width] * len(holding))


def test_it_starts_and_ends_with_a_closed_gripper_and_keeps_its_distance(context, executed):
    _, action, result = executed
    closed, motion = context.robot.gripper.closed, action.motion
    assert motion.opening == closed
    assert motion.segments[-1].opening == closed
    assert motion.segments[-1].held is None
    assert np.array_equal(motion.start, context.problem.initial.joint_positions)
    poses = result.final_state.object_poses
    # The conservative checker keeps 2 mm on its own.
    assert context.collision.world(poses, opening=closed, margin=0.017).free(motion.end)[0]


def test_the_trial_begins_where_the_fingers_close(executed):
    _, action, _ = executed
    trial = action.motion.after_transit()
    assert trial.segments[0].kind is SegmentKind.GRIPPER
    assert trial.segments[0].opening < trial.opening
    assert trial.segments[1].kind is SegmentKind.LIFT


def test_the_fingers_close_on_the_object_and_open_clear_of_it(context, executed):
    name, action, _ = executed
    scene, state = context.problem.scene, context.problem.initial
    others = [entity for entity in scene.entities[1:] if entity != name]
    checker = ExactChecker(scene, context.robot)
    closing, lift = next(
        pair for pair in pairwise(action.motion.segments) if pair[1].kind is SegmentKind.LIFT
    )
    at = lift.trajectory.positions[:1]
    opened = next(s.opening for s in action.motion.segments if s.kind is SegmentKind.REACH)
    for opening, free in ((opened, True), (closing.opening - 0.001, False)):
        world = checker.world(state.object_poses, opening=opening, ignore=others)
        assert world.free(at)[0] == free


def test_the_verifier_sees_whether_the_fingers_closed_on_the_object(context, executed):
    name, action, result = executed
    motion, width = action.motion, action.motion.after_transit().opening

    def said(segments):
        states = result.segment_states
        return check_fingers(context.problem, segments, states, context.robot, motion.opening)

    assert said(motion.segments) == []
    agape = tuple(
        replace(s, opening=width) if s.closes_on is not None else s for s in motion.segments
    )
    assert said(agape) == [f"lift: the fingers do not close on {name!r} from both sides"]


def test_speeds_and_lift_follow_the_options(context):
    (fast, *_), _ = proposals(context, asked(context, "can"))
    (slow, *_), _ = proposals(context, asked(context, "can"), carry_speed=0.1, lift=0.02)
    assert slow.motion.duration > fast.motion.duration + 1.0
    heights = []
    for action in (fast, slow):
        lift = next(s for s in action.motion.segments if s.kind is SegmentKind.LIFT)
        ends = [context.kinematics.forward(q)[2, 3] for q in lift.trajectory.positions[[0, -1]]]
        heights.append(ends[1] - ends[0])
    assert heights == pytest.approx([0.04, 0.02], abs=1e-3)


@pytest.mark.parametrize(
    ("name", "cause"), [("beside", "ungraspable"), ("blocker", "tipped")], ids=["wide", "tipped"]
)
def test_refused_with_its_cause(context, name, cause):
    state = placed(context, name, tilt=np.radians(8.0))
    found, statistics = proposals(context, asked(context, name), state=state)
    assert found == []
    assert dict(statistics.causes) == {f"{name}/pick_place/{cause}": 1}


def test_what_friction_cannot_carry_is_not_picked_up(context):
    heavy = [
        replace(item, mass=20.0) if item.name == "can" else item
        for item in context.problem.scene.objects
    ]
    scene = replace(context.problem.scene, objects=tuple(heavy))
    problem = replace(context.problem, scene=scene)
    found, statistics = proposals(replace(context, problem=problem), asked(context, "can"))
    assert found == []
    causes = {key.rsplit("/", 1)[1] for key in statistics.causes}
    assert "grip_too_weak" in causes


def test_a_slightly_leaning_object_is_not_refused(context):
    state = placed(context, "blocker", tilt=np.radians(1.0))
    found, statistics = proposals(context, asked(context, "blocker"), state=state)
    assert found, statistics.causes


def test_no_room_for_the_hand(context):
    state = placed(context, "can", xy=(0.9, -0.62))
    state = SceneState(
        state.joint_positions,
        np.where(
            np.arange(len(state.object_poses))[:, None] == context.problem.scene.index("blocker"),
            placed(context, "blocker", xy=(0.82, -0.64)).object_poses,
            state.object_poses,
        ),
    )
    found, statistics = proposals(context, asked(context, "can"), state=state)
    assert found == []
    assert set(statistics.causes) <= {
        f"can/pick_place/{cause}"
        for cause in ("grasp_hand_blocked", "grasp_no_ik", "grasp_blocked", "reach_blocked")
    }


def test_an_occupied_goal_is_refused(context):
    request = asked(context, "can", goal=(0.62, -0.47))
    found, statistics = proposals(context, request, count=3, nearby=0.0)
    assert found == []
    causes = {key.rsplit("/", 1)[1] for key in statistics.causes}
    assert causes & {"place_hand_blocked", "place_blocked", "lower_blocked"}


def test_next_to_an_occupied_goal_there_may_be_room(context):
    goal = np.array([0.62, -0.52])
    request = asked(context, "can", goal=goal)
    assert proposals(context, request, nearby=0.0)[0] == []
    found, statistics = proposals(context, request, nearby=0.1)
    assert found, statistics.causes
    assert 0.005 < np.abs(found[0].path[-1] - goal).max() < 0.1


def test_places_where_the_object_is_already_are_not_proposed(context):
    request = asked(context, "can", goal=(0.63, -0.7))
    found, statistics = proposals(context, request, nearby=0.0)
    assert found == []
    assert dict(statistics.causes) == {"can/pick_place/no_free_place": 1}
    found, _ = proposals(context, asked(context, "can", goal=None), count=3, shortest=0.15)
    start = context.problem.initial.object_poses[context.problem.scene.index("can"), :2]
    assert all(np.linalg.norm(action.path[-1] - start) >= 0.15 for action in found)


@pytest.mark.parametrize("seed", range(3))
def test_without_a_path_the_object_goes_to_a_free_place_outside_the_region(context, seed):
    request = asked(context, "blocker", goal=None, swept=LEFT)
    found, statistics = proposals(context, request, seed=seed)
    assert found, statistics.causes
    result = context.backend.rollout(context.problem.initial, found[0].motion)
    assert result.valid, result.violations
    number = context.problem.scene.index("blocker")
    pose = result.final_state.object_poses[number]
    shape = context.problem.scene.objects[number].shape
    assert LEFT.overlaps(shape, context.problem.initial.object_poses[number])
    assert not LEFT.overlaps(shape, pose)
    assert result.moved == ("blocker",)


def test_no_place_left(context):
    full = region(lambda x, y: np.ones_like(x, dtype=bool))
    found, statistics = proposals(context, asked(context, "can", goal=None, swept=full))
    assert found == []
    assert dict(statistics.causes) == {"can/pick_place/no_free_place": 1}


def test_the_same_seed_gives_the_same_actions(context):
    request = asked(context, "can", goal=None, swept=NOWHERE)
    one, again = (proposals(context, request, seed=4, count=2)[0] for _ in range(2))
    other = proposals(context, request, seed=5, count=2)[0]
    assert len(one) == len(again) == 2
    for a, b in zip(one, again, strict=True):
        assert np.array_equal(a.path, b.path)
        for s, t in zip(a.motion.segments, b.motion.segments, strict=True):
            assert np.array_equal(s.trajectory.positions, t.trajectory.positions)
    assert not np.array_equal(one[0].path, other[0].path)


def test_at_most_as_many_as_asked_for_and_only_when_asked(context):
    found, _ = proposals(context, asked(context, "can"), count=10, samples=2)
    assert len(found) == 2
    _, first = proposals(context, asked(context, "can"), count=1)
    _, more = proposals(context, asked(context, "can"), count=3)
    assert 0 < first.counts["arm_plans"] < more.counts["arm_plans"]
    _, none = proposals(context, asked(context, "can"), count=0)
    assert not none.counts
    assert not none.causes


def test_where_the_fingers_have_no_room_the_arm_goes_home_before_it_opens(context):
    motion = proposals(context, asked(context, "can"))[0][0].motion
    reach = next(s for s in motion.segments if s.kind is SegmentKind.REACH)
    where = reach.trajectory.positions[-1]
    state, request = beside_the_closed_hand(context, where, reach.opening)
    found, statistics = proposals(context, request, state=state)
    assert found, statistics.causes
    first, second = found[0].motion.segments[:2]
    assert first.kind is SegmentKind.TRANSIT
    assert first.opening == context.robot.gripper.closed
    assert first.trajectory.positions[-1] == pytest.approx(context.problem.home)
    assert second.kind is SegmentKind.GRIPPER


def beside_the_closed_hand(context, where, opening):
    """The arm at ``where`` and a box so near that only the closed hand is clear of it."""
    poses = np.array(context.problem.initial.object_poses)
    index = context.problem.scene.index
    poses[index("can"), :2] = (0.62, -0.35)
    T = context.kinematics.forward(where)
    for gap in np.arange(0.05, 0.15, 0.002):
        poses[index("blocker"), :2] = T[:2, 3] - gap * T[:2, 1]
        closed, opened = (
            context.collision.world(poses, opening=width).free(where)[0]
            for width in (context.robot.gripper.closed, opening)
        )
        if closed and not opened:
            return SceneState(where, poses), asked(context, "can", goal=(0.62, -0.2))
    raise AssertionError("no such place")
