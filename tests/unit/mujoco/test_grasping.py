"""The hand closes on the target: with the gripper's force, and without breaking a rule."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from mamo_mujoco.engine import MuJoCoWorld

from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.scene import SceneState

ALL = RolloutOptions(stop_early=False)
WIDTH, OPEN = 0.06, 0.07


@pytest.fixture(scope="module")
def closing(grasping):
    """The problem with the hand around the target, and a motion that closes, lifts and carries."""
    problem, motion = grasping
    poses = np.array(problem.initial.object_poses)
    poses[problem.scene.target_index, 0] -= 0.025  # the pads are behind the tool frame
    problem = replace(problem, initial=SceneState(problem.initial.joint_positions, poses))
    start = motion.start
    still = Trajectory.still(start, 0.5)
    close = MotionSegment(SegmentKind.GRIPPER, still, WIDTH, contact_free=True, closes_on="target")
    holding = tuple(replace(s, opening=WIDTH) for s in motion.segments)
    return problem, Motion((close, *holding), OPEN)


@pytest.mark.parametrize("grasp", ["weld", "friction"])
def test_it_closes_lifts_and_carries(model_of, closing, grasp):
    problem, motion = closing
    result = model_of(problem, grasp=grasp).rollout(problem.initial, motion, options=ALL)
    assert result.valid, result.violations
    assert ("robot", "target") in result.contacts
    target = problem.scene.target_index
    rise = result.final_state.object_poses[target] - problem.initial.object_poses[target]
    assert rise[:3] == pytest.approx([-0.1, 0.0, 0.07], abs=0.006)


def test_only_what_is_closed_on_may_be_touched(model_of, closing):
    problem, motion = closing
    unsaid = replace(motion, segments=(replace(motion.segments[0], closes_on=None, opening=0.055),))
    result = model_of(problem).rollout(problem.initial, unsaid, options=ALL)
    assert {(v.constraint, v.subject, v.other) for v in result.violations} == {
        ("contact", "robot", "target")
    }


def test_friction_goes_on_bit_for_bit(model_of, closing):
    """Also in the middle of a hold, and after a world has been used for something else."""
    problem, motion = closing
    model = model_of(problem, grasp="friction")
    whole = model.rollout(problem.initial, motion, options=ALL).final_state
    first, second = Motion(motion.segments[:2], OPEN), Motion(motion.segments[2:], WIDTH)
    kept = RolloutOptions(stop_early=False, keep=True)
    half = model.rollout(problem.initial, first, options=kept)
    model.rollout(problem.initial, first, options=ALL)
    rest = model.rollout(
        half.final_state, second, options=ALL, continue_from=half.continuation
    ).final_state
    assert np.array_equal(rest.object_poses, whole.object_poses)
    assert np.array_equal(rest.joint_positions, whole.joint_positions)


def test_each_finger_presses_with_the_force_of_the_gripper(model_of, closing, arm, monkeypatch):
    """Measured at the contacts when the fingers have closed."""
    problem, motion = closing
    forces = {}

    def measured(world, place):
        data, model = world._data, world._model
        geom = model.geom("target").id
        for number in range(data.ncon):
            pair = data.contact[number].geom.tolist()
            if place >= 0 and geom in pair:
                force = np.zeros(6)
                mujoco.mj_contactForce(model, data, number, force)
                other = model.geom(pair[1 - pair.index(geom)]).name
                side = next((s for s in ("_l_", "_r_") if s in other), "floor")
                forces[side] = forces.get(side, 0.0) + force[0]
        return original(world, place)

    original = MuJoCoWorld.hold
    monkeypatch.setattr(MuJoCoWorld, "hold", measured)
    model_of(problem).rollout(problem.initial, motion, options=ALL)
    for side in ("_l_", "_r_"):
        assert 0.75 * arm.gripper.force < forces[side] < 1.1 * arm.gripper.force
