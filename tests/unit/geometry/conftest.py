"""A cluttered shelf and the parts that are tested in it."""

import numpy as np
import pytest
from mamo_geometry.kinematics import ChainKinematics
from mamo_geometry.options import KinematicsOptions, SphereCheckerOptions
from mamo_geometry.sphere_checker import SphereChecker

from mamo_core.problems import generate_shelf
from mamo_core.robots import load_arm
from mamo_core.robots.exact_collision import ExactChecker
from mamo_core.types.geometry import tool_matrix


@pytest.fixture(scope="session")
def arm():
    return load_arm("pr2_right_arm")


@pytest.fixture(scope="session")
def shelf():
    return generate_shelf(movables=10, seed=1)


@pytest.fixture(scope="session")
def kinematics(shelf, arm):
    return ChainKinematics(shelf.scene, arm, KinematicsOptions())


@pytest.fixture(scope="session")
def checker(shelf, arm):
    return SphereChecker(shelf.scene, arm, SphereCheckerOptions())


@pytest.fixture(scope="session")
def exact(shelf, arm):
    return ExactChecker(shelf.scene, arm)


@pytest.fixture(scope="session")
def reaching(shelf, kinematics):
    """Configurations (k, dof) with the tool somewhere in the shelf, most of them near objects."""
    rng = np.random.default_rng(4)
    space = shelf.scene.workspace
    found = []
    for _ in range(300):
        position = rng.uniform(space.lower, space.upper) - [0.1, 0.0, 0.0]
        position[2] = space.floor + rng.uniform(0.03, 0.25)
        T = tool_matrix(position, rng.uniform(-0.8, 0.8), rng.uniform(0.0, 0.6))
        found.append(kinematics.inverse(T, rng, count=2))
    return np.vstack(found)
