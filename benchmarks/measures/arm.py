"""RRT-Connect from home to where a grasp of any object in a cluttered shelf begins."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np

from mamo_core.build_context import BuildContext
from mamo_core.interfaces.arm_planner import ArmPlan
from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.plugins import Registry
from mamo_core.problems.grasps import default_grasps
from mamo_core.robots.grasps import hand_of
from mamo_core.types.geometry import Array, matrix_from_pose
from measures.common import Measured, cpu_seconds, shelves

MOVABLES = 10
QUERIES = 60
GOALS = 30


def measure(registry: Registry) -> Measured:
    """CPU time of a multi-goal query, shortcuts included."""
    milliseconds: list[float] = []
    solved = 0
    for context, world, goals in islice(_queries(registry), QUERIES):
        plans: list[ArmPlan] = []
        planner, home = context.part("arm_planner"), context.problem.home
        rng = np.random.default_rng(len(milliseconds))
        seconds = cpu_seconds(
            lambda p=planner, h=home, g=goals, w=world, r=rng, out=plans: out.append(
                p.plan(h, g, w, r)
            )
        )
        milliseconds.append(1e3 * seconds)
        solved += plans[0].path is not None
    p90 = float(np.quantile(milliseconds, 0.9))
    how = (
        f"{QUERIES} queries home -> up to {GOALS} free pregrasp configurations of an object, "
        f"shelves of {MOVABLES + 5} objects; {solved} solved; p90 {p90:.1f} ms; CPU, "
        "shortcuts included"
    )
    key = "arm_plan_ms_median"
    return Measured({key: float(np.median(milliseconds))}, {key: how})


def _queries(registry: Registry) -> Iterator[tuple[BuildContext, CollisionWorld, Array]]:
    for context in shelves(registry, MOVABLES, ("kinematics", "collision", "arm_planner")):
        poses = context.problem.initial.object_poses
        opening = context.robot.gripper.max_opening
        world = context.part("collision").world(poses, opening=opening)
        rng = np.random.default_rng(0)
        for number in range(len(poses)):
            goals = _pregrasps(context, number, rng)
            free = goals[world.free(goals)] if len(goals) else goals
            if len(free):
                yield context, world, free[:GOALS]


def _pregrasps(context: BuildContext, number: int, rng: np.random.Generator) -> Array:
    """Configurations (k, dof) from which the hand would go straight to an object."""
    scene, poses = context.problem.scene, context.problem.initial.object_poses
    found = [np.empty((0, context.robot.dof))]
    for grasp in default_grasps(scene.objects[number], hand_of(scene.robot)):
        T = matrix_from_pose(poses[number]) @ matrix_from_pose(grasp.T_object_tool)
        T[:3, 3] -= grasp.approach * T[:3, 0]
        found.append(context.part("kinematics").inverse(T, rng, count=4))
    return np.vstack(found)
