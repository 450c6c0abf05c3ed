"""Holds that are none are refused: hands that are open, beside, too early, or too weak."""

from dataclasses import replace

import numpy as np
import pytest

from mamo_core.robots import load_arm
from mamo_core.robots.kinematics import tool_transform
from mamo_core.types.geometry import matrix_from_pose
from mamo_core.types.motion import SegmentKind, Trajectory
from mamo_core.verify import verify
from mamo_core.verify_grasp import check_fingers, check_handling, finger_sides, holds


@pytest.fixture
def failures(problem, planner):
    """``failures(plan)``: what the verifier says."""

    def check(plan):
        return verify(problem, plan, planner.context.backend, planner.context.robot).failures

    return check


@pytest.fixture(scope="module")
def executed(problem, planner, plan):
    """Segments of the retrieval and the states at their starts, and the last opening before it."""
    rollout = planner.verify(plan).rollout
    count = len(plan.retrieval.segments)
    return plan.retrieval.segments, rollout.segment_states[-count:], plan.retrieval.opening


@pytest.fixture
def said(problem, planner, executed):
    """``said(segments, states)``: what is wrong with the fingers, both as executed by default."""
    segments, states, opening = executed

    def check(changed=segments, where=states, scene=problem):
        return check_fingers(scene, changed, where, planner.context.robot, opening)

    return check


def changed(plan, change):
    """The plan with ``change(segment)`` for every segment of the retrieval."""
    segments = tuple(change(segment) for segment in plan.retrieval.segments)
    return replace(plan, retrieval=replace(plan.retrieval, segments=segments))


def open_width(plan):
    """Of the hand before it closes on the target, m."""
    return next(s.opening for s in plan.retrieval.segments if s.kind is SegmentKind.REACH)


def handles(segment):
    return segment.held is not None or segment.closes_on is not None


def test_an_honest_hold(said, executed):
    assert said() == []
    (hold,) = holds(executed[0])
    segments = executed[0]
    assert hold.name == "target"
    assert [s.kind for s in segments[hold.first - 1 : hold.last + 1]] == [
        "gripper",
        "lift",
        "carry",
    ]
    assert hold.last == len(segments) - 1


def test_the_hand_stays_open(failures, plan):
    """As if nothing had to be closed: the target floats between open fingers."""
    opened = open_width(plan)

    def agape(segment):
        return replace(segment, opening=opened, closes_on=None) if handles(segment) else segment

    assert failures(changed(plan, agape)) == (
        "motion 1: the fingers do not close on 'target' before it is held",
        "motion 1: gripper: the fingers must close on 'target', or let go of it, just then",
    )


def test_the_hand_closes_too_little(failures, plan):
    """By less than it takes to touch, which no form shows."""
    wide = open_width(plan) - 0.001

    def wider(segment):
        return replace(segment, opening=wide) if handles(segment) else segment

    assert failures(changed(plan, wider)) == (
        "lift: the fingers do not close on 'target' from both sides",
    )


def test_the_hand_is_said_to_close_more_than_the_target_lets_it(failures, plan):
    def narrower(segment):
        if not handles(segment):
            return segment
        path = segment.trajectory
        if segment.closes_on is not None:  # in so much time that the fingers are not too fast
            path = replace(path, times=3.0 * path.times)
        return replace(segment, trajectory=path, opening=segment.opening - 0.01)

    assert failures(changed(plan, narrower)) == (
        "lift: the fingers are said to be closer than 'target' lets them",
    )


def test_the_fingers_open_while_they_hold(failures, plan):
    def let_go(segment):
        wide = open_width(plan)
        return replace(segment, opening=wide) if segment.kind is SegmentKind.CARRY else segment

    assert failures(changed(plan, let_go)) == (
        "motion 1: the fingers move while they hold 'target'",
    )


def moved_when_held(problem, executed, shift):
    """The states, with the target elsewhere by ``shift`` (3,) m, in the tool frame, once held."""
    segments, states, _ = executed
    first = next(holds(segments)).first
    robot = load_arm(problem.scene.robot)
    T = matrix_from_pose(problem.scene.T_world_base) @ tool_transform(
        robot, segments[first].trajectory.positions[0]
    )
    poses = np.array(states[first].object_poses)
    poses[problem.scene.target_index, :3] += T[:3, :3] @ shift
    return [*states[:first], replace(states[first], object_poses=poses), *states[first + 1 :]]


def test_one_finger_is_not_enough(problem, executed, said):
    """The target is nearer to one of them by more than it could be pressed aside."""
    near = moved_when_held(problem, executed, [0.0, 0.001, 0.0])
    assert said(where=near) == []
    beside = moved_when_held(problem, executed, [0.0, 0.004, 0.0])
    assert said(where=beside) == ["lift: the fingers do not close on 'target' from both sides"]


def test_the_target_is_welded_from_afar(problem, executed, said):
    """11 cm in front of the tool."""
    afar = moved_when_held(problem, executed, [0.11, 0.0, 0.0])
    assert said(where=afar) == ["lift: the fingers do not close on 'target' from both sides"]


def test_fingers_that_are_in_the_target_before_they_close(executed, said):
    segments, _, _ = executed
    closing = next(holds(segments)).first - 1
    narrow = segments[closing].opening - 0.01
    pressed = [replace(s, opening=narrow) if n < closing else s for n, s in enumerate(segments)]
    assert said(pressed) == ["lift: the fingers touch 'target' before they close on it"]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"mass": 20.0}, "friction does not carry its weight"),
        ({"friction": 0.02}, "friction does not carry its weight"),
    ],
)
def test_what_friction_cannot_carry(problem, said, change, expected):
    target = problem.scene.target_index
    objects = [
        replace(o, **change) if i == target else o for i, o in enumerate(problem.scene.objects)
    ]
    heavy = replace(problem, scene=replace(problem.scene, objects=tuple(objects)))
    assert said(scene=heavy) == [f"lift: 'target' cannot be held: {expected}"]


def test_closing_is_allowed_just_before_a_hold_alone(plan):
    """A hand that may touch the target all the time could push it."""

    def always(segment):
        return replace(segment, closes_on="target")

    found = check_handling(changed(plan, always))
    assert len(found) == len(plan.retrieval.segments) - 1
    assert found[0] == (
        "motion 1: transit: the fingers must close on 'target', or let go of it, just then"
    )


def test_the_arm_stands_still_while_the_fingers_close(plan):
    def moving(segment):
        if segment.closes_on is None:
            return segment
        positions = np.array(segment.trajectory.positions)
        middle = positions[0] + np.eye(len(positions[0]))[0] * 0.01
        times = np.array([0.0, 0.25, 0.5])
        way = Trajectory.through(times, np.stack([positions[0], middle, positions[0]]))
        return replace(segment, trajectory=way)

    assert check_handling(changed(plan, moving)) == [
        "motion 1: gripper: the arm must stand still while the fingers move"
    ]


def test_what_is_put_down_is_let_go_of(plan):
    """A motion that goes on after a hold must open the hand first."""
    carry = plan.retrieval.segments[-1]
    end = carry.trajectory.positions[-1]
    still = Trajectory.still(end, 0.5)
    after = replace(carry, kind=SegmentKind.TRANSIT, trajectory=still, held=None)
    longer = replace(plan.retrieval, segments=(*plan.retrieval.segments, after))
    assert check_handling(replace(plan, retrieval=longer)) == [
        "motion 1: the fingers do not open to let go of 'target'",
        "motion 1: transit: the fingers must close on 'target', or let go of it, just then",
    ]
    opened = replace(
        after, kind=SegmentKind.GRIPPER, opening=carry.opening + 0.01, closes_on="target"
    )
    longer = replace(plan.retrieval, segments=(*plan.retrieval.segments, opened))
    assert check_handling(replace(plan, retrieval=longer)) == []


def test_both_sides_of_known_hands(planner):
    assert sorted(finger_sides(planner.context.robot).values()) == [-1, -1, 1, 1]
