"""Compiles every kernel on a tiny problem, so that nobody waits for it later."""

from __future__ import annotations

import numpy as np

from mamo_core.robots import load_arm
from mamo_core.types.geometry import Box, make_pose
from mamo_core.types.scene import Fixture, Mobility, Scene, SceneObject, Workspace
from mamo_geometry.kinematics import ChainKinematics
from mamo_geometry.options import KinematicsOptions, RRTConnectOptions, SphereCheckerOptions
from mamo_geometry.rrt_connect import RRTConnect
from mamo_geometry.sphere_checker import SphereChecker


def warm_up() -> None:
    """Call every kernel once."""
    arm = load_arm("pr2_right_arm")
    box = Box(np.array([0.05, 0.05, 0.1]))
    scene = Scene(
        arm.name,
        make_pose([0.0, 0.0, 0.0]),
        (Fixture("board", box, make_pose([2.0, 0.0, 0.0])),),
        (SceneObject("target", box, Mobility.TARGET, 0.1, 1.0),),
        Workspace(np.array([0.5, -0.5, 0.7]), np.array([1.0, 0.5, 1.0])),
    )
    rng = np.random.default_rng(0)
    kinematics = ChainKinematics(scene, arm, KinematicsOptions())
    T = kinematics.forward(arm.home)
    kinematics.jacobian(arm.home)
    kinematics.inverse(T, rng, count=1, near=arm.home)
    line = kinematics.follow_line(arm.home, T)
    checker = SphereChecker(scene, arm, SphereCheckerOptions())
    world = checker.world(np.array([make_pose([3.0, 0.0, 0.0])]), opening=0.0)
    world.edges_free(line.path[:1], line.path[-1:])
    world.hands_free(T[None])
    near_home = arm.home[None, :] + 0.01
    RRTConnect(arm, RRTConnectOptions()).plan(arm.home, near_home, world, rng)
    checker.swept_region(line.path, opening=0.0)
