"""The boxes around meshes and objects spare pairs that are apart, and no others."""

import fcl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mamo_core.interfaces.collision_checker import HeldObject
from mamo_core.problems import generate_shelf
from mamo_core.robots import load_arm
from mamo_core.robots.exact_collision import ExactChecker, _boxes_meet
from mamo_core.robots.self_collision import SelfCollisions
from mamo_core.types.geometry import Box, make_pose, matrix_from_pose


@pytest.fixture(scope="module")
def arm():
    return load_arm("pr2_right_arm")


@pytest.fixture(scope="module")
def shelf():
    return generate_shelf(movables=8, seed=2)


@pytest.fixture(scope="module")
def configurations(arm):
    """Anywhere within reach, so that many touch something, the shelf or an object."""
    low, high = np.maximum(arm.lower, -2.0), np.minimum(arm.upper, 2.0)
    return np.random.default_rng(3).uniform(low, high, size=(150, arm.dof))


def without_boxes(world):
    """The same world, in which every mesh is held against every obstacle."""

    def every_pair(T_world_pieces):
        pieces, count = T_world_pieces.shape[:2]
        obstacles = len(world._obstacles)
        return np.argwhere(np.ones((count, pieces, obstacles), dtype=bool))

    world._near = every_pair
    return world


@pytest.mark.parametrize("carrying", [False, True])
def test_boxes_change_no_verdict(arm, shelf, configurations, carrying):
    held = HeldObject("box", Box(np.array([0.1, 0.2, 0.3])), np.eye(4)) if carrying else None
    checker = ExactChecker(shelf.scene, arm)
    worlds = [checker.world(shelf.initial.object_poses, opening=0.05, held=held) for _ in range(2)]
    quick, thorough = worlds[0], without_boxes(worlds[1])
    free = quick.free(configurations)
    assert 20 < free.sum() < 130
    assert np.array_equal(free, thorough.free(configurations))
    for row in configurations:
        assert quick.first_touched(row) == thorough.first_touched(row)


def rotations(rng, count):
    quats = rng.normal(size=(count, 4))
    return np.array([matrix_from_pose([0, 0, 0, *quat])[:3, :3] for quat in quats])


@given(st.integers(0, 10**6))
def test_boxes_that_touch_meet(seed):
    """Compared with the engine's own boxes; a little too often is fine, never too seldom."""
    rng = np.random.default_rng(seed)
    count = 40
    R_one, R_other = rotations(rng, count), rotations(rng, count)
    R_other[: count // 2] = R_one[: count // 2]  # parallel edges, the delicate case
    halves = rng.uniform(0.01, 0.3, size=(2, count, 3))
    ways = rng.normal(scale=0.25, size=(count, 3))
    meet = _boxes_meet(R_one, halves[0], R_other, halves[1], ways)
    for i in range(count):
        one, other = (
            fcl.CollisionObject(fcl.Box(*(2.0 * half[i])), fcl.Transform(R[i], where))
            for half, R, where in zip(halves, (R_one, R_other), (np.zeros(3), ways[i]), strict=True)
        )
        assert bool(fcl.collide(one, other)) == meet[i]


def test_boxes_that_just_touch_meet():
    """Whatever is rounded on the way."""
    half = np.full((1, 3), 0.1)
    for angle in np.linspace(0.0, 2.0, 50):
        R = matrix_from_pose(make_pose([0, 0, 0], angle))[None, :3, :3]
        for axis in range(3):
            way = 0.2 * R[:, :, axis]
            assert _boxes_meet(R, half, R, half, way)[0]
            assert not _boxes_meet(R, half, R, half, way * (1.0 + 1e-6))[0]


def test_a_world_without_obstacles_is_free_but_for_the_robot_itself(arm, shelf, configurations):
    world = ExactChecker(shelf.scene, arm).world(
        shelf.initial.object_poses, opening=0.05, ignore=shelf.scene.entities
    )
    own = SelfCollisions(arm).free(configurations, 0.05)
    assert np.array_equal(world.free(configurations), own)
    assert 0 < own.sum() < len(own)
    assert world.first_touched(configurations) is None


def test_drives_of_many_openings_are_those_of_each(arm):
    openings = np.linspace(-0.01, arm.gripper.max_opening + 0.01, 57)
    each = [arm.gripper.drive(float(opening)) for opening in openings]
    assert arm.gripper.drives(openings).tolist() == each
