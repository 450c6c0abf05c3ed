"""Configuration checks: the sphere kernel beside python-fcl on the arm's meshes."""

from __future__ import annotations

from itertools import islice

import numpy as np

from mamo_core.build_context import BuildContext
from mamo_core.plugins import Registry
from mamo_core.robots.exact_collision import ExactChecker
from mamo_core.types.geometry import Array, tool_matrix
from measures.common import Measured, cpu_seconds, shelves

MOVABLES = 15
"""With 4 immovables and the target: 20 objects."""
CONFIGURATIONS = 6_000
"""In each of the scenes."""
SCENES = 2
REPEATS = 10
NOISE = 0.1


def measure(registry: Registry) -> Measured:
    """Rates on the same configurations, and collisions that the spheres miss."""
    contexts = islice(shelves(registry, MOVABLES, ("kinematics", "collision")), SCENES)
    checked, missed, alarms, free, fast, slow = 0, 0, 0, 0, [], []
    for number, context in enumerate(contexts):
        configurations = sample(context, np.random.default_rng(number))
        poses = context.problem.initial.object_poses
        for opening in (context.robot.gripper.closed, context.robot.gripper.max_opening):
            spheres = context.part("collision").world(poses, opening=opening)
            exact = ExactChecker(context.problem.scene, context.robot).world(poses, opening=opening)
            quick = spheres.free(configurations)
            truth: list[Array] = []
            slow.append(_rate(lambda e=exact, t=truth, c=configurations: t.append(e.free(c)), 1))
            fast.append(_rate(lambda s=spheres, c=configurations: s.free(c), REPEATS))
            checked += len(configurations)
            missed += int((quick & ~truth[0]).sum())
            alarms += int((~quick & truth[0]).sum())
            free += int(truth[0].sum())
    ours, theirs = float(np.median(fast)), float(np.median(slow))
    return Measured(
        {"config_checks_per_s": ours, "checks_vs_fcl": ours / theirs, "missed_collisions": missed},
        {
            "config_checks_per_s": f"{checked} configurations in {SCENES} scenes of 20 objects, "
            f"gripper closed and open, {free} free; one core",
            "checks_vs_fcl": f"python-fcl on the same configurations: {theirs:,.0f}/s",
            "missed_collisions": f"of {checked - free} mesh collisions; {alarms} of {free} free "
            "configurations are refused for safety",
        },
    )


def sample(context: BuildContext, rng: np.random.Generator) -> Array:
    """Configurations (k, dof): half anywhere, half with the hand somewhere in the shelf."""
    arm, half = context.robot, CONFIGURATIONS // 2
    low, high = arm.around_home
    anywhere = rng.uniform(low, high, (half, arm.dof))
    inside = np.empty((0, arm.dof))
    while len(inside) < half:
        near = _in_shelf(context, rng)
        spread = near.repeat(4, axis=0) + rng.normal(0.0, NOISE, (4 * len(near), arm.dof))
        inside = np.vstack([inside, near, np.clip(spread, arm.lower, arm.upper)])
    return np.vstack([anywhere, inside[:half]])


def _in_shelf(context: BuildContext, rng: np.random.Generator) -> Array:
    """Configurations that bring the tool to a random pose in the workspace."""
    workspace = context.problem.scene.workspace
    position = rng.uniform(workspace.lower, workspace.upper)
    T = tool_matrix(position, rng.uniform(-1.0, 1.0), rng.uniform(-0.3, 0.7))
    found: Array = context.part("kinematics").inverse(T, rng, count=4)
    return found


def _rate(check: object, repeats: int) -> float:
    """Configurations per CPU second; a first call is not counted if there are several."""
    assert callable(check)
    if repeats > 1:
        check()
    seconds = [cpu_seconds(check) for _ in range(repeats)]
    return CONFIGURATIONS / float(np.median(seconds))
