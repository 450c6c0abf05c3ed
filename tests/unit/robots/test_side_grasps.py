"""Grasps on the arm's own meshes: the open hand clears the object, the fingers close on it."""

import numpy as np
import pytest

from mamo_core.problems import generate_shelf
from mamo_core.robots.exact_collision import ExactChecker
from mamo_core.robots.grasps import HANDS, dipped_grasps, side_grasps
from mamo_core.robots.kinematics import tool_transform
from mamo_core.robots.library import load_arm
from mamo_core.types.geometry import (
    Box,
    Cylinder,
    invert,
    matrix_from_pose,
    pose_from_matrix,
    tool_matrix,
)
from mamo_core.types.scene import Mobility, Scene, SceneObject

SHAPES = (
    Cylinder(0.03, 0.15),
    Cylinder(0.038, 0.2),
    Box(np.array([0.06, 0.06, 0.18])),
    Box(np.array([0.07, 0.16, 0.25])),
)


def meets(robot, shape, grasp, opening, back=0.0):
    """Whether the robot's meshes touch the shape with the hand ``back`` (m) from the grasp."""
    arm = load_arm(robot)
    T_tool = tool_transform(arm, arm.home)
    T_grasp = matrix_from_pose(grasp.T_object_tool)
    T_grasp[:3, 3] -= back * T_grasp[:3, 0]
    pose = pose_from_matrix(T_tool @ invert(T_grasp))
    item = SceneObject("item", shape, Mobility.MOVABLE, 0.2, 1.0)
    workspace = generate_shelf(movables=0, seed=0).scene.workspace
    scene = Scene(robot, np.array([0.0, 0, 0, 1, 0, 0, 0]), (), (item,), workspace)
    world = ExactChecker(scene, arm).world(pose[None, :], opening=opening)
    return not world.free(arm.home)[0]


def width_of(shape, grasp):
    if isinstance(shape, Cylinder):
        return 2.0 * shape.radius
    return float(np.abs(matrix_from_pose(grasp.T_object_tool)[:3, 1]) @ shape.size)


@pytest.mark.parametrize("robot", sorted(HANDS))
@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_the_open_hand_clears_the_object_and_the_fingers_close_on_it(robot, shape):
    grasps = (*side_grasps(shape, HANDS[robot])[::3], *dipped_grasps(shape, HANDS[robot])[::3])
    assert grasps
    for grasp in grasps:
        width = width_of(shape, grasp)
        assert grasp.opening > width
        for share in (0.0, 0.3, 1.0):
            assert not meets(robot, shape, grasp, grasp.opening, share * grasp.approach)
        assert meets(robot, shape, grasp, width - 0.004)


def test_a_dipped_hand_points_down_and_holds_near_the_top():
    shape = Box(np.array([0.06, 0.12, 0.2]))
    grasps = dipped_grasps(shape, HANDS["pr2_right_arm"], pitches=(0.4,))
    assert grasps
    for grasp in grasps:
        T = matrix_from_pose(grasp.T_object_tool)
        yaw = float(np.arctan2(T[1, 0], T[0, 0]))
        np.testing.assert_allclose(T, tool_matrix(T[:3, 3], yaw, 0.4), atol=1e-9)
        assert 0.02 < shape.height / 2.0 - T[2, 3] < 0.05


def test_a_dip_that_leaves_too_little_of_the_fingers_on_the_object_is_left_out():
    shape = Cylinder(0.03, 0.2)
    hand = HANDS["pr2_right_arm"]
    assert dipped_grasps(shape, hand, pitches=(0.25,))
    assert dipped_grasps(shape, hand, pitches=(1.2,)) == ()


def test_other_heights_on_request():
    grasps = side_grasps(Cylinder(0.03, 0.2), HANDS["pr2_right_arm"], heights=(0.05, 0.1, 0.19))
    found = {round(float(g.T_object_tool[2]) + 0.1, 6) for g in grasps}
    assert found == {0.05, 0.1}
