"""The verifier accepts a real plan and refuses every kind of broken one."""

from dataclasses import replace

import numpy as np
import pytest

from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.robots.timing import time_path
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import tool_matrix
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.problem import ConstraintSpec
from mamo_core.types.rollout import Violation
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Plan
from mamo_core.verify import verify, verify_executed


@pytest.fixture
def failures(problem, planner):
    """``failures(plan)``: what the verifier says."""

    def check(plan):
        return verify(problem, plan, planner.context.backend, planner.context.robot).failures

    return check


def with_segment(motion, which, **changes):
    """The motion with every segment of a kind changed."""
    segments = [replace(s, **changes) if s.kind is which else s for s in motion.segments]
    return replace(motion, segments=tuple(segments))


def with_action(plan, motion=None, **changes):
    """The plan with its first action changed."""
    action = replace(plan.actions[0], **changes)
    if motion is not None:
        action = replace(action, motion=motion)
    return replace(plan, actions=(action, *plan.actions[1:]))


def with_retrieval(plan, segments):
    return replace(plan, retrieval=replace(plan.retrieval, segments=tuple(segments)))


def closing_of(plan):
    """The segment in which the fingers close on the target."""
    return next(s for s in plan.retrieval.segments if s.closes_on is not None)


def mentions(failures, text):
    assert any(text in failure for failure in failures), failures


def test_the_plan_holds(planner, plan):
    report = planner.verify(plan)
    assert report.failures == ()
    assert report.ok
    assert report.rollout.valid
    assert {"blocker", "target"} <= set(report.rollout.moved)
    assert "post" not in report.rollout.moved


def test_another_model_says_the_same(problem, planner, compose_for, plan):
    fresh = compose_for(problem)
    assert fresh.context.backend is not planner.context.backend
    one, other = planner.verify(plan), fresh.verify(plan)
    assert one.failures == other.failures
    assert one.rollout.steps == other.rollout.steps
    a, b = one.rollout.final_state, other.rollout.final_state
    assert np.array_equal(a.object_poses, b.object_poses)
    assert np.array_equal(a.joint_positions, b.joint_positions)


@pytest.fixture
def executed(problem, planner, plan):
    """What the engine does motion by motion, each from where the one before ended."""
    model, state, token, results = planner.context.backend, problem.initial, None, []
    for motion in plan.motions:
        options = RolloutOptions(keep=True)
        result = model.rollout(state, motion, options=options, continue_from=token)
        state, token = result.final_state.with_joints(motion.end), result.continuation
        results.append(result)
    return results


def test_what_was_executed_need_not_be_replayed(problem, planner, plan, executed):
    one = planner.verify(plan).rollout
    report = verify_executed(problem, plan, executed, planner.context.robot)
    other = report.rollout
    assert report.ok
    assert np.array_equal(one.final_state.object_poses, other.final_state.object_poses)
    assert (one.steps, one.contacts) == (other.steps, other.contacts)
    assert one.duration == pytest.approx(other.duration)
    assert one.segment_times == pytest.approx(other.segment_times)
    for a, b in zip(one.segment_states, other.segment_states, strict=True):
        assert np.array_equal(a.object_poses, b.object_poses)


def test_what_was_executed_is_judged_like_a_replay(problem, planner, plan, executed):
    robot = planner.context.robot
    tipped = Violation("tilt", "blocker", None, 0.5, 1.0, 0.4)
    broken = [*executed[:-1], replace(executed[-1], violations=(tipped,))]
    report = verify_executed(problem, plan, broken, robot)
    assert report.kinds == ("tilt",)
    begin = sum(result.duration for result in executed[:-1])
    assert report.rollout.violations[0].time == pytest.approx(begin + 0.5)
    stalled = [replace(executed[0], stalled=True), *executed[1:]]
    assert verify_executed(problem, plan, stalled, robot).kinds == ("stalled",)
    crashed = [replace(executed[0], lost="crashed"), *executed[1:]]
    assert verify_executed(problem, plan, crashed, robot).lost
    late = with_retrieval(plan, plan.retrieval.segments[:-1])
    assert verify_executed(problem, late, executed, robot).kinds == ("form",)
    moved = executed[-1].final_state.object_poses.copy()
    moved[problem.scene.target_index, 0] += 0.1
    final = replace(executed[-1].final_state, object_poses=moved)
    dropped = [*executed[:-1], replace(executed[-1], final_state=final)]
    assert verify_executed(problem, plan, dropped, robot).kinds == ("not_retrieved",)


def test_every_motion_must_have_been_executed(problem, planner, plan, executed):
    with pytest.raises(ValueError, match="results for"):
        verify_executed(problem, plan, executed[:-1], planner.context.robot)


def test_a_trace_on_request(problem, planner, plan):
    context = planner.context
    report = verify(problem, plan, context.backend, context.robot, trace_step=0.1)
    assert report.rollout.trace.times[-1] == pytest.approx(report.rollout.duration, abs=0.1)


def test_without_its_action_it_starts_elsewhere(failures, plan):
    found = failures(replace(plan, actions=()))
    assert found == ("motion 0 (transit): does not start where the arm is",)


def test_a_jump_within_a_motion_cannot_be_written_down(plan):
    with pytest.raises(ValueError, match="rad away from the end of"):
        with_retrieval(plan, [*plan.retrieval.segments[:-2], plan.retrieval.segments[-1]])


def test_joint_limit(failures, planner, plan):
    robot = planner.context.robot
    joint = 3  # the elbow
    motion = plan.actions[0].motion
    transit = motion.segments[0]
    positions = np.array(transit.trajectory.positions)
    middle = len(positions) // 2
    positions[middle, joint] = robot.upper[joint] + 0.01
    changed = replace(transit, trajectory=replace(transit.trajectory, positions=positions))
    segments = (changed, *motion.segments[1:])
    found = failures(with_action(plan, replace(motion, segments=segments)))
    mentions(found, f"motion 0 (transit): {robot.joint_names[joint]} exceeds its limit by ")


def test_a_way_through_the_own_torso(problem, planner, plan):
    """A sweep, which may touch things, but not the robot itself."""
    home, motion = problem.home, plan.actions[0].motion
    inside = home.copy()
    inside[0], inside[1] = 0.7, 1.2
    path = time_path(np.stack([home, inside, home]), planner.context.robot.limits, scale=0.3)
    detour = MotionSegment(SegmentKind.SWEEP, path, motion.opening)
    changed = with_action(plan, replace(motion, segments=(detour, *motion.segments)))
    report = verify(problem, changed, planner.context.backend, planner.context.robot)
    assert report.rollout is not None, report.failures
    # As an engine that sees no contacts would have executed it.
    executed = [
        replace(
            report.rollout,
            violations=(),
            stalled=False,
            segment_states=(problem.initial,) * len(m.segments),
        )
        for m in changed.motions
    ]
    blind = verify_executed(problem, changed, executed, planner.context.robot)
    assert "self_collision" in blind.kinds
    mentions(blind.failures, " collides with ")


def test_velocity_limit(failures, plan):
    motion = plan.actions[0].motion
    hurried = [
        replace(s, trajectory=replace(s.trajectory, times=s.trajectory.times * 0.2))
        for s in motion.segments
    ]
    found = failures(with_action(plan, replace(motion, segments=tuple(hurried))))
    mentions(found, "motion 0 (transit): velocity limit exceeded")


def test_it_must_end_at_home(failures, plan):
    carry = plan.retrieval.segments[-1]
    rows = len(carry.trajectory.times) // 2
    half = carry.trajectory.part(0, rows - 1)
    found = failures(
        with_retrieval(plan, [*plan.retrieval.segments[:-1], replace(carry, trajectory=half)])
    )
    mentions(found, "motion 1 (carry): it does not end at rest")
    assert found[-1] == "the plan does not end at home"


@pytest.mark.parametrize("name", ["post", "target", "floor"])
def test_only_movables_are_rearranged(failures, plan, name):
    mentions(failures(with_action(plan, object_name=name)), f"action 0 rearranges {name!r}")


def test_an_action_lets_go(failures, plan):
    motion = with_segment(plan.actions[0].motion, SegmentKind.RETRACT, held="blocker")
    found = failures(with_action(plan, motion))
    assert found == ("action 0 ends with 'blocker' in the hand",)


def test_an_action_holds_its_own_object_alone(failures, plan):
    motion = with_segment(plan.actions[0].motion, SegmentKind.SWEEP, held="beside")
    assert failures(with_action(plan, motion)) == ("action 0 holds 'beside'",)


def test_a_retrieval_without_the_target(failures, plan):
    empty = [replace(s, held=None) for s in plan.retrieval.segments]
    found = failures(with_retrieval(plan, empty))
    assert found == ("the retrieval does not end with 'target' in the hand",)


def test_a_retrieval_of_something_else(failures, plan):
    segments = [
        replace(s, held="beside") if s.kind is SegmentKind.LIFT else s
        for s in plan.retrieval.segments
    ]
    mentions(failures(with_retrieval(plan, segments)), "does not end with 'target' in the hand")


@pytest.mark.parametrize("opening", [-0.01, 0.5])
def test_impossible_opening(failures, plan, opening):
    motion = with_segment(plan.actions[0].motion, SegmentKind.SWEEP, opening=opening)
    found = failures(with_action(plan, motion))
    assert found[0] == f"motion 0 (sweep): opening {opening} m is not possible"


def excursion(problem, planner, xy, *, contact_free):
    """An action that moves the hand in beside a place, through it and back home."""
    context = planner.context
    name = problem.scene.objects[0].name
    opening = context.robot.gripper.closed
    rng = np.random.default_rng(0)
    T = tool_matrix([xy[0] - 0.12, xy[1], 0.86], 0.0)
    T_end = tool_matrix([xy[0] + 0.03, xy[1], 0.86], 0.0)
    world = context.collision.world(problem.initial.object_poses, opening=opening)
    for q in context.kinematics.inverse(T, rng, count=6):
        line = context.kinematics.follow_line(q, T_end)
        approach = context.arm_planner.plan(problem.home, q[None], world, rng)
        if line.fraction == 1.0 and approach.path is not None:
            break
    else:
        raise AssertionError("no way to get there")

    def segment(kind, path, contact_free):
        trajectory = time_path(path, context.robot.limits, scale=0.3)
        return MotionSegment(kind, trajectory, opening, contact_free=contact_free, settle=0.5)

    motion = Motion(
        (
            segment(SegmentKind.TRANSIT, approach.path, True),
            segment(SegmentKind.SWEEP, line.path, contact_free),
            segment(SegmentKind.RETRACT, line.path[::-1], False),
            segment(SegmentKind.TRANSIT, approach.path[::-1], True),
        ),
        opening,
    )
    return RearrangementAction("push", name, motion, np.zeros((1, 2)))


def test_touching_an_immovable(problem, planner, failures, plan):
    action = excursion(problem, planner, (0.9, -0.2), contact_free=False)
    found = failures(replace(plan, actions=(action, *plan.actions)))
    mentions(found, "contact: robot - post at ")


def test_touching_the_target_before_it_is_held(planner, failures, plan):
    """The hand runs into it, opened too little, instead of taking it between open fingers."""
    first = plan.retrieval.segments.index(closing_of(plan))
    narrow = closing_of(plan).opening + 1e-6
    squeezed = [
        replace(s, opening=narrow) if n < first else s
        for n, s in enumerate(plan.retrieval.segments)
    ]
    mentions(failures(with_retrieval(plan, squeezed)), "contact: robot - target at ")


def test_a_contact_free_segment_that_touches(failures, plan):
    motion = with_segment(plan.actions[0].motion, SegmentKind.SWEEP, contact_free=True)
    assert failures(with_action(plan, motion)) == ("sweep: the arm's mesh touches blocker",)


def test_its_name_does_not_make_a_segment_contact_free(failures, plan):
    motion = with_segment(
        plan.actions[0].motion, SegmentKind.SWEEP, contact_free=True, kind=SegmentKind.GRIPPER
    )
    mentions(failures(with_action(plan, motion)), "the arm's mesh touches blocker")


def at_rest(problem, robot, **changes):
    standing = Trajectory.still(problem.home, 0.5)
    closed = robot.gripper.closed
    return Motion((MotionSegment(SegmentKind.CARRY, standing, closed, **changes),), closed)


def test_the_target_is_not_held_from_afar(problem, planner, failures):
    """The arm stays at home and claims to hold the target, which stands in the shelf."""
    assert failures(Plan((), at_rest(problem, planner.context.robot, held="target")))


class Slippery:
    """A model in which the target ends somewhere else."""

    def __init__(self, model, problem):
        self._model, self._problem = model, problem

    def rollout(self, *arguments, **options):
        result = self._model.rollout(*arguments, **options)
        poses = np.array(result.final_state.object_poses)
        poses[self._problem.scene.target_index, 0] += 0.05
        final = SceneState(result.final_state.joint_positions, poses)
        return replace(result, final_state=final)


def test_the_target_must_end_in_the_hand(problem, planner, plan):
    context = planner.context
    report = verify(problem, plan, Slippery(context.backend, problem), context.robot)
    (failure,) = report.failures
    assert failure.startswith("the target is ")
    assert failure.endswith(" cm away from where the hand should hold it")


@pytest.mark.parametrize(
    ("constraint", "expected"),
    [
        (ConstraintSpec("speed", {"limit": 0.05}), "speed: blocker at "),
        (ConstraintSpec("tilt", {"limit_deg": 0.05}), "tilt: "),
    ],
)
def test_broken_constraints_of_the_problem(problem, compose_for, plan, constraint, expected):
    strict = replace(problem, constraints=(constraint,))
    mentions(compose_for(strict).verify(plan).failures, expected)


def test_an_immovable_that_stands_in_the_way(problem, planner, compose_for, plan):
    """The same plan, with the post where the pushed object comes to rest."""
    blocker, post = problem.scene.index("blocker"), problem.scene.index("post")
    pushed = planner.verify(plan).rollout.final_state.object_poses[blocker]
    poses = np.array(problem.initial.object_poses)
    poses[post, :2] = pushed[:2]
    moved = replace(problem, initial=SceneState(problem.home, poses))
    mentions(compose_for(moved).verify(plan).failures, "contact: blocker - post at ")


def test_an_arm_that_cannot_follow(problem, compose_for, plan):
    weak = compose_for(problem, "backend={name: mujoco, effort: 0.05}").context
    found = verify(problem, plan, weak.backend, weak.robot).failures
    mentions(found, "the arm could not follow its trajectory")


def test_all_violations_are_listed(problem, compose_for, plan):
    """The replay does not end at the first one."""
    constraints = (
        ConstraintSpec("speed", {"limit": 0.05}),
        ConstraintSpec("tilt", {"limit_deg": 0.05}),
    )
    found = compose_for(replace(problem, constraints=constraints)).verify(plan).failures
    mentions(found, "speed: blocker at ")
    mentions(found, "tilt: ")
    assert len(found) > 2
