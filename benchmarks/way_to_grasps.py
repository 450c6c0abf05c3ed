"""Is there any way for the open hand to the target, on meshes and as if there were no movables?

    python benchmarks/way_to_grasps.py PROBLEM[#ID] --checks 300000

counts arm configurations that are free at the problem's grasps, those from which the hand can go
straight back, and asks RRT-Connect for a way from home to any of them. That none is found proves
nothing.
"""

from __future__ import annotations

import argparse

import numpy as np

from mamo_core.compose import compose
from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.plugins import discover
from mamo_core.problems import load_problem
from mamo_core.recipe_sets import chosen_recipe
from mamo_core.robots.exact_collision import ExactChecker
from mamo_core.types.geometry import Array, matrix_from_pose
from mamo_core.types.scene import Mobility

_BRANCHES = 40
_STEP = 0.01


def main() -> None:
    """Looks at the grasps of one opening after the other."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("problem")
    parser.add_argument("--checks", type=int, default=100_000, help="configurations for each way")
    parser.add_argument("--back", type=float, default=0.04, help="how far straight back, m")
    arguments = parser.parse_args()
    problem = load_problem(arguments.problem)
    recipe = chosen_recipe("default", settings=("arm_planner=ompl_rrt_connect",))
    context = compose(recipe, problem, discover()).context
    kinematics, rng = context.part("kinematics"), np.random.default_rng(0)
    scene, poses = problem.scene, problem.initial.object_poses
    movables = [o.name for o in scene.objects if o.mobility is Mobility.MOVABLE]
    T_world_target = matrix_from_pose(poses[scene.target_index])
    exact = ExactChecker(scene, context.robot)
    for opening in sorted({grasp.opening for grasp in problem.grasps}):
        world = exact.world(poses, opening=opening, ignore=movables)
        tools = [
            T_world_target @ matrix_from_pose(grasp.T_object_tool)
            for grasp in problem.grasps
            if grasp.opening == opening
        ]
        free = [(T, q) for T in tools for q in _free(kinematics, T, world, rng)]
        straight = sum(_straight_back(kinematics, T, q, world, arguments.back) for T, q in free)
        print(f"fingers {opening * 1000:.0f} mm apart: {len(tools)} grasps, {len(free)} free")
        print(f"  straight back by {arguments.back * 100:.0f} cm: {straight}")
        if free:
            goals = np.array([q for _, q in free])
            planner = context.part("arm_planner")
            found = planner.plan(problem.home, goals, world, rng, max_checks=arguments.checks)
            print(f"  from home: {found.status} after {found.checks} checks")


def _free(
    kinematics: Kinematics, T: Array, world: CollisionWorld, rng: np.random.Generator
) -> Array:
    """Configurations (k, dof) that bring the tool to ``T`` (4, 4) and touch nothing."""
    found = kinematics.inverse(T, rng, count=_BRANCHES)
    return found[world.free(found)] if len(found) else found


def _straight_back(
    kinematics: Kinematics, T: Array, q: Array, world: CollisionWorld, length: float
) -> bool:
    """Whether the hand can leave by so much (m) along its axis."""
    T_back = T.copy()
    T_back[:3, 3] -= length * T[:3, 0]
    line = kinematics.follow_line(q, T_back, step=_STEP)
    return line.fraction == 1.0 and bool(world.free(line.path).all())


if __name__ == "__main__":
    main()
