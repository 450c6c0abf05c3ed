"""The MAPF abstraction of a state (thesis 4.4.1) and how occupied a region is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mamo_core.types.mapf import GoalPenalty, MAPFAgent, MAPFObstacle, MAPFProblem
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility, SceneState

_MARGIN = 0.002


def mapf_problem(
    problem: Problem,
    state: SceneState,
    region: SweptRegion,
    penalties: Mapping[str, Sequence[GoalPenalty]],
    goal_margin: float,
) -> MAPFProblem:
    """Movables as agents that leave ``region``, everything else an obstacle.

    Objects may pass over the open front as far as the workspace's overhang, but not end there.
    """
    scene = problem.scene
    agents, obstacles = [], []
    for item, pose in zip(scene.objects, state.object_poses, strict=True):
        if item.mobility is Mobility.MOVABLE:
            own = tuple(penalties.get(item.name, ()))
            agents.append(MAPFAgent(item.name, item.shape, pose, own))
        else:
            obstacles.append(MAPFObstacle(item.name, item.shape, pose))
    lower, upper = scene.workspace.lower[:2], scene.workspace.upper[:2]
    overhang = np.array([scene.workspace.overhang, 0.0])
    return MAPFProblem(
        agents=tuple(agents),
        obstacles=tuple(obstacles),
        region=region,
        transit_lower=lower - overhang,
        transit_upper=upper,
        goal_lower=lower,
        goal_upper=upper,
        margin=_MARGIN,
        goal_margin=goal_margin,
    )


def occupied(problem: Problem, state: SceneState, region: SweptRegion) -> list[str]:
    """Names of the movables inside the region."""
    scene = problem.scene
    return [
        scene.objects[i].name
        for i in scene.movable_indices
        if region.overlaps(scene.objects[i].shape, state.object_poses[i])
    ]


def occupancy(problem: Problem, state: SceneState, region: SweptRegion) -> tuple[int, float]:
    """Number of movables inside the region and the area (m^2) they take there."""
    scene = problem.scene
    areas = [
        region.overlap(scene.objects[i].shape, state.object_poses[i]) for i in scene.movable_indices
    ]
    return sum(area > 0.0 for area in areas), float(sum(areas))
