"""The scripted scene of the contract tests, and a plain floor to slide on."""

from dataclasses import replace

import numpy as np
import pytest
from mamo_geometry.kinematics import ChainKinematics
from mamo_geometry.options import KinematicsOptions
from mamo_mujoco.model import MuJoCoModel
from mamo_mujoco.options import MuJoCoOptions

from mamo_core.robots import load_arm
from mamo_core.testing.transition_cases import pr2_cases, standard_constraints
from mamo_core.types.geometry import Box, make_pose, tool_matrix
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.scene import Fixture, SceneState


@pytest.fixture(scope="session")
def arm():
    return load_arm("pr2_right_arm")


@pytest.fixture(scope="session")
def cases():
    return pr2_cases()


def make_model(problem, **options):
    arm = load_arm(problem.scene.robot)
    return MuJoCoModel(problem, arm, standard_constraints(problem), MuJoCoOptions(**options))


@pytest.fixture(scope="session")
def model(cases):
    return make_model(cases.problem)


@pytest.fixture(scope="session")
def model_of():
    return make_model


@pytest.fixture(scope="session")
def on_a_plain(cases):
    """``on_a_plain(objects, positions)``: a wide floor at z = 0, far from the arm."""

    def build(objects, poses):
        floor = Fixture("floor", Box(np.array([4.0, 4.0, 0.2])), make_pose([5.0, 0.0, -0.1]))
        scene = replace(cases.problem.scene, objects=tuple(objects), fixtures=(floor,))
        initial = SceneState(cases.problem.home, np.array(poses))
        return replace(cases.problem, scene=scene, initial=initial)

    return build


@pytest.fixture(scope="session")
def grasping(cases, arm):
    """The problem with the hand around the target, and a motion that takes it 10 cm up and out."""
    problem = cases.problem
    index = problem.scene.target_index
    kinematics = ChainKinematics(problem.scene, arm, KinematicsOptions())
    poses = np.array(problem.initial.object_poses)
    poses[index, :2] = 0.62, -0.5
    poses[problem.scene.index("can"), :2] = 0.9, -0.75
    T = tool_matrix(poses[index, :3], 0.0)
    T_up, T_out = T.copy(), T.copy()
    T_up[2, 3] += 0.07
    T_out[:3, 3] += [-0.1, 0.0, 0.07]
    for q in kinematics.inverse(T, np.random.default_rng(0), count=8):
        up = kinematics.follow_line(q, T_up)
        out = kinematics.follow_line(up.path[-1], T_out)
        if up.fraction == out.fraction == 1.0:
            break
    opening = 0.07
    lifted, taken = (
        MotionSegment(
            kind, Trajectory.through(np.linspace(0, 1.0, len(path)), path), opening, "target", True
        )
        for kind, path in ((SegmentKind.LIFT, up.path), (SegmentKind.CARRY, out.path))
    )
    changed = replace(problem, initial=SceneState(q, poses))
    return changed, Motion((lifted, taken), opening)
