"""A cluttered shelf, and a world without any geometry."""

import numpy as np
import pytest
from mamo_geometry.kinematics import ChainKinematics
from mamo_geometry.options import KinematicsOptions, SphereCheckerOptions
from mamo_geometry.sphere_checker import SphereChecker
from mamo_ompl.arm_planner import OmplArmPlanner
from mamo_ompl.kinds import KINDS

from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.problems import generate_shelf
from mamo_core.robots import load_arm
from mamo_core.types.geometry import tool_matrix


@pytest.fixture(scope="session")
def arm():
    return load_arm("pr2_right_arm")


@pytest.fixture(scope="session")
def shelf_world(arm):
    shelf = generate_shelf(movables=10, seed=1)
    checker = SphereChecker(shelf.scene, arm, SphereCheckerOptions())
    return checker.world(shelf.initial.object_poses, opening=0.0), shelf


@pytest.fixture(scope="session")
def world(shelf_world):
    return shelf_world[0]


@pytest.fixture(scope="session")
def reaching(shelf_world, arm):
    """Configurations (k, dof) with the tool somewhere in the shelf."""
    shelf = shelf_world[1]
    kinematics = ChainKinematics(shelf.scene, arm, KinematicsOptions())
    rng, space, found = np.random.default_rng(4), shelf.scene.workspace, []
    for _ in range(300):
        position = rng.uniform(space.lower, space.upper) - [0.1, 0.0, 0.0]
        position[2] = space.floor + rng.uniform(0.03, 0.25)
        T = tool_matrix(position, rng.uniform(-0.8, 0.8), rng.uniform(0.0, 0.6))
        found.append(kinematics.inverse(T, rng, count=2))
    return np.vstack(found)


@pytest.fixture(scope="session")
def goals(world, reaching):
    return reaching[world.free(reaching)]


@pytest.fixture(scope="session")
def hard_goals(world, goals, arm):
    """Those that the straight line from home does not reach."""
    starts = np.repeat(arm.home[None], len(goals), axis=0)
    return goals[~world.edges_free(starts, goals)]


class Wall(CollisionWorld):
    """Joint 0 between ``low`` and ``high`` is blocked unless joint 1 is beyond ``top``."""

    def __init__(self, low=-0.6, high=-0.4, top=0.2):
        self.low, self.high, self.top = low, high, top
        self.asked = 0

    def free(self, configurations):
        self.asked += len(configurations)
        inside = (configurations[:, 0] > self.low) & (configurations[:, 0] < self.high)
        return ~(inside & (configurations[:, 1] < self.top))

    def edges_free(self, starts, ends):
        shares = np.linspace(0.0, 1.0, 200)[:, None]
        ways = starts[:, None] + shares * (ends - starts)[:, None]
        return np.array([self.free(way).all() for way in ways])


@pytest.fixture(scope="session")
def wall():
    return Wall


@pytest.fixture(scope="session")
def planner(arm):
    def make(name="ompl_rrt_connect", **options):
        kind = KINDS[name]
        return OmplArmPlanner(arm, kind, kind.options(**options))

    return make


@pytest.fixture
def across(arm):
    """Two configurations with the wall between."""
    start, goal = arm.home.copy(), arm.home.copy()
    start[:2], goal[:2] = (-1.2, 0.0), (0.2, 0.0)
    return start, goal
