"""The scripted scene of the contract tests, and a plain floor to slide on."""

from dataclasses import replace

import numpy as np
import pytest
from mamo_mujoco.model import MuJoCoModel
from mamo_mujoco.options import MuJoCoOptions

from mamo_core.robots import load_arm
from mamo_core.testing.transition_cases import pr2_cases, standard_constraints
from mamo_core.types.geometry import Box, make_pose
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
