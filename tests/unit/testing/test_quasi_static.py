from __future__ import annotations

import numpy as np
import pytest

from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.robots.kinematics import tool_transform
from mamo_core.robots.library import load_arm
from mamo_core.testing.gantry import GantryKinematics
from mamo_core.testing.quasi_static import QuasiStaticModel, QuasiStaticOptions
from mamo_core.testing.transition_cases import (
    gantry_cases,
    pr2_cases,
    standard_constraints,
    there_and_back,
)
from mamo_core.types.geometry import Array, Box, make_pose, tool_matrix
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides
from mamo_core.types.scene import Fixture, Mobility, Scene, SceneObject, SceneState, Workspace

CASES = gantry_cases()


def row_of_boxes(count: int) -> Problem:
    """Movable boxes 4 cm wide behind each other along x, 1 cm apart; a wall behind the last."""
    shape = Box(np.array([0.04, 0.04, 0.1]))
    objects = [SceneObject(f"b{i}", shape, Mobility.MOVABLE, 0.2, 1.0) for i in range(count)]
    objects.append(SceneObject("t", shape, Mobility.TARGET, 0.2, 1.0))
    poses = [make_pose([0.1 + 0.05 * i, 0.0, 0.05]) for i in range(count)]
    poses.append(make_pose([0.1, 0.4, 0.05]))
    wall = Fixture("wall", Box(np.array([0.02, 1.0, 0.2])), make_pose([0.4, 0.0, 0.1]))
    space = Workspace(np.array([0.0, -0.5, 0.0]), np.array([0.39, 0.5, 0.3]))
    scene = Scene("gantry", make_pose([0, 0, 0]), (wall,), tuple(objects), space)
    joints = np.array([0.0, 0.0, 0.05, 0.0])
    return Problem("row", scene, SceneState(joints, np.array(poses)), joints, ())


def push_to(x: float, y: float = 0.0) -> Motion:
    path = np.array([[0.0, 0.0, 0.05, 0.0], [x, y, 0.05, 0.0]])
    return there_and_back(path, float(np.hypot(x, y)))


def model(problem: Problem, **options: float) -> QuasiStaticModel:
    return QuasiStaticModel(
        problem,
        GantryKinematics().forward,
        standard_constraints(problem),
        QuasiStaticOptions(**options),
    )


def test_a_pushed_object_ends_in_front_of_the_fingers() -> None:
    problem = row_of_boxes(1)
    result = model(problem).rollout(problem.initial, push_to(0.2))
    # Finger radius 1 cm, half a box 2 cm.
    assert result.final_state.object_poses[0, 0] == pytest.approx(0.23)
    assert result.moved == ("b0",)
    assert result.contacts == {("robot", "b0")}
    assert result.duration == pytest.approx(4.0)


def test_a_chain_moves_as_one() -> None:
    problem = row_of_boxes(3)
    result = model(problem).rollout(problem.initial, push_to(0.2))
    np.testing.assert_allclose(
        result.final_state.object_poses[:3, 0], [0.23, 0.27, 0.31], atol=1e-4
    )
    assert ("b0", "b1") in result.contacts
    assert ("b0", "b2") not in result.contacts


def test_a_wall_stalls_the_arm() -> None:
    problem = row_of_boxes(1)
    result = model(problem).rollout(problem.initial, push_to(0.38))
    assert result.stalled
    assert not result.valid
    assert ("b0", "wall") in result.contacts


def test_too_much_friction_stalls_the_arm() -> None:
    problem = row_of_boxes(3)
    # Three boxes of 0.2 kg at mu 1 resist with 5.9 N.
    assert not model(problem, max_force=6.0).rollout(problem.initial, push_to(0.2)).stalled
    assert model(problem, max_force=5.8).rollout(problem.initial, push_to(0.2)).stalled
    heavy = ParameterOverrides(masses={"b1": 10.0})
    assert model(problem).rollout(problem.initial, push_to(0.2), parameters=heavy).stalled


def test_overrides_of_unknown_objects_are_refused() -> None:
    problem = row_of_boxes(1)
    with pytest.raises(KeyError, match="no object 'b9'; objects: b0, t"):
        model(problem).rollout(
            problem.initial, push_to(0.1), parameters=ParameterOverrides(frictions={"b9": 1.0})
        )


def test_a_fast_push_breaks_the_speed_limit() -> None:
    problem = row_of_boxes(1)
    positions = np.array([[0.0, 0.0, 0.05, 0.0], [0.2, 0.0, 0.05, 0.0]])
    sweep = Trajectory.through(np.array([0.0, 0.1]), positions)
    motion = Motion((MotionSegment(SegmentKind.SWEEP, sweep, 0.0),), 0.0)
    result = model(problem).rollout(problem.initial, motion)
    assert [v.constraint for v in result.violations] == ["speed"]


def test_the_tool_passes_above_low_objects() -> None:
    problem = row_of_boxes(1)
    lifted = np.array([[0.0, 0.0, 0.15, 0.0], [0.2, 0.0, 0.15, 0.0]])
    result = model(problem).rollout(problem.initial, there_and_back(lifted, 0.2))
    assert result.contacts == frozenset()


def fetch(problem: Problem) -> Motion:
    """Straddle the target, hold it, carry it 20 cm towards +x."""
    x, y = problem.initial.object_poses[-1, :2]
    stations = [[0.0, y, 0.05, 0.0], [x, y, 0.05, 0.0], [x + 0.2, y, 0.05, 0.0]]
    times = np.array([0.0, 2.0])
    reach = Trajectory.through(times, np.array(stations[:2]))
    carry = Trajectory.through(times, np.array(stations[1:]))
    return Motion(
        (
            MotionSegment(SegmentKind.REACH, reach, 0.05, contact_free=True),
            MotionSegment(SegmentKind.CARRY, carry, 0.05, held="t", contact_free=True),
        ),
        opening=0.05,
    )


def test_a_held_object_moves_with_the_tool() -> None:
    problem = row_of_boxes(0)
    result = model(problem).rollout(problem.initial, fetch(problem))
    assert result.valid, [str(v) for v in result.violations]
    np.testing.assert_allclose(result.final_state.object_poses[-1, :2], [0.3, 0.4], atol=1e-9)


def test_a_held_object_must_not_touch_others() -> None:
    problem = row_of_boxes(1)
    poses = np.array(problem.initial.object_poses)
    poses[0, :2] = [0.2, 0.4]
    result = model(problem).rollout(
        SceneState(problem.initial.joint_positions, poses), fetch(problem)
    )
    assert [(v.constraint, {v.subject, v.other}) for v in result.violations] == [
        ("contact", {"b0", "t"})
    ]


def test_closed_fingers_push_the_target_and_that_is_a_violation() -> None:
    problem = row_of_boxes(0)
    result = model(problem).rollout(problem.initial, push_to(0.1, 0.4))
    assert [(v.constraint, {v.subject, v.other}) for v in result.violations] == [
        ("contact", {"robot", "t"})
    ]
    assert result.duration < push_to(0.1, 0.4).duration


def test_foreign_continuations_are_refused() -> None:
    problem = row_of_boxes(1)
    one, two = model(problem), model(problem)
    result = one.rollout(problem.initial, push_to(0.2), options=RolloutOptions(keep=True))
    for wrong in (object(), result.continuation):
        with pytest.raises(ValueError, match="not the continuation of a rollout of this model"):
            two.rollout(result.final_state, push_to(0.2), continue_from=wrong)


def test_the_pr2_push_is_a_straight_line() -> None:
    arm = load_arm("pr2_right_arm")
    cases = pr2_cases()
    path = cases.crash.segments[0].trajectory.positions
    xs = np.linspace(0.56, 0.80, len(path))
    for joints, x in zip(path, xs, strict=True):
        assert arm.within_limits(joints)
        expected = tool_matrix([x, -0.45, 0.86], 0.0)
        np.testing.assert_allclose(tool_transform(arm, joints), expected, atol=2e-3)


def test_the_pr2_cases_hold_in_the_fake_world() -> None:
    arm = load_arm("pr2_right_arm")
    cases = pr2_cases()

    def tool(joints: Array) -> Array:
        return tool_transform(arm, joints)

    world = QuasiStaticModel(cases.problem, tool, standard_constraints(cases.problem))
    pushed = world.rollout(cases.problem.initial, cases.push)
    assert pushed.valid
    assert pushed.moved == (cases.pushed,)
    crashed = world.rollout(cases.problem.initial, cases.crash)
    assert [{v.subject, v.other} for v in crashed.violations] == [{cases.pushed, cases.hit}]


class TestGantry:
    kinematics = GantryKinematics()

    def test_inverse_undoes_forward(self) -> None:
        q = np.array([0.3, -0.2, 0.5, 0.7])
        found = self.kinematics.inverse(
            self.kinematics.forward(q), np.random.default_rng(0), count=3
        )
        np.testing.assert_allclose(found, q[None, :])

    def test_pitched_and_distant_poses_have_no_inverse(self) -> None:
        rng = np.random.default_rng(0)
        for T in (tool_matrix([0, 0, 1], 0.0, pitch=0.3), tool_matrix([5, 0, 1], 0.0)):
            assert self.kinematics.inverse(T, rng, count=3).shape == (0, 4)

    def test_jacobian_is_the_derivative(self) -> None:
        q = np.array([0.3, -0.2, 0.5, 0.7])
        J = self.kinematics.jacobian(q)
        for i in range(3):
            step = np.zeros(4)
            step[i] = 1e-6
            shift = (self.kinematics.forward(q + step) - self.kinematics.forward(q))[:3, 3]
            np.testing.assert_allclose(shift / 1e-6, J[:3, i], atol=1e-6)
        assert J[5, 3] == 1.0

    def test_lines_stop_at_the_limits(self) -> None:
        line = self.kinematics.follow_line(np.array([1.9, 0, 1, 0]), tool_matrix([2.1, 0, 1], 0.0))
        assert line.fraction == pytest.approx(0.5)
        assert line.path[-1, 0] == pytest.approx(2.0)
        whole = self.kinematics.follow_line(
            np.array([0.0, 0.0, 1.0, 0.0]), tool_matrix([1, 0, 1], 1.0)
        )
        assert whole.fraction == 1.0
        np.testing.assert_allclose(whole.path[-1], [1, 0, 1, 1])
