"""A shelf with a box in front of the target, and real parts without physics."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from mamo_geometry.kinematics import ChainKinematics
from mamo_geometry.options import KinematicsOptions, RRTConnectOptions, SphereCheckerOptions
from mamo_geometry.rrt_connect import RRTConnect
from mamo_geometry.sphere_checker import SphereChecker

from mamo_core.problems import generate_shelf
from mamo_core.problems.documents import automatic_grasps
from mamo_core.robots import load_arm
from mamo_core.types.geometry import Box, Cylinder, make_pose
from mamo_core.types.scene import Mobility, SceneObject, SceneState

THINGS = {
    "blocker": (Box(np.array([0.07, 0.12, 0.2])), Mobility.MOVABLE, (0.58, -0.5)),
    "beside": (Box(np.array([0.06, 0.06, 0.18])), Mobility.MOVABLE, (0.9, -0.8)),
    "post": (Cylinder(0.03, 0.2), Mobility.IMMOVABLE, (0.9, -0.2)),
    "target": (Cylinder(0.03, 0.16), Mobility.TARGET, (0.7, -0.5)),
}


def build(changes=None, **scene_changes):
    """The shelf with other places, or other (shape, mobility, place)."""
    empty = generate_shelf(movables=0, seed=1)
    floor = empty.scene.workspace.floor
    objects, poses = [], []
    for name, (shape, kind, xy) in {**THINGS, **(changes or {})}.items():
        objects.append(SceneObject(name, shape, kind, 0.2, 1.0))
        poses.append(make_pose([*xy, floor + shape.height / 2.0]))
    scene = replace(empty.scene, objects=tuple(objects), **scene_changes)
    target = poses[scene.target_index]
    return replace(
        empty,
        name="small",
        scene=scene,
        initial=SceneState(empty.home, np.array(poses)),
        grasps=automatic_grasps(scene, target),
    )


def equip(problem):
    """Arm, kinematics, checker and arm planner for a problem."""
    arm = load_arm(problem.scene.robot)
    return SimpleNamespace(
        arm=arm,
        kinematics=ChainKinematics(problem.scene, arm, KinematicsOptions()),
        collision=SphereChecker(problem.scene, arm, SphereCheckerOptions()),
        arm_planner=RRTConnect(arm, RRTConnectOptions()),
    )


@pytest.fixture(scope="session")
def shelf_with():
    return build


@pytest.fixture(scope="session")
def parts_of():
    return equip


@pytest.fixture(scope="session")
def problem():
    return build()


@pytest.fixture(scope="session")
def parts(problem):
    return equip(problem)
