"""What one call of a planner that reaches looks at: goals, obstacles, and the way to go."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.types.geometry import Array, Shape
from mamo_core.types.problem import Problem
from mamo_core.types.scene import Mobility
from mamo_planners.reaching.distance_field import DistanceField
from mamo_planners.reaching.goals import Goals
from mamo_planners.reaching.options import LatticeOptions, PrimitiveOptions

if TYPE_CHECKING:
    from mamo_planners.reaching.stand import ReachingParts

_TOOL_STEP = 0.05
"""What a primitive moves the tool by, about, m."""

_NO_WAY = 10.0
"""Where the tool has no way around obstacles it is said to have this far to go, m."""

_MARGIN = 0.3
"""How far the heuristic's box reaches beyond the workspace and the tool at home, m."""


@dataclass(frozen=True, eq=False)
class Scenery:
    """``fixed``: what must not be touched; ``everything``: all objects at their initial poses."""

    goals: Goals
    fixed: CollisionWorld
    everything: CollisionWorld
    field: DistanceField

    def primitives_to_go(self, point: Array) -> float:
        """The anchor heuristic where the tool is at ``point`` (3,)."""
        return primitives_to_go(self.field, point)


def primitives_to_go(field: DistanceField, point: Array) -> float:
    """About how many primitives bring the tool from ``point`` (3,) to where the field is 0."""
    way = field.distance(point)
    return (way if math.isfinite(way) else _NO_WAY) / _TOOL_STEP


def look_at(parts: ReachingParts, goals: Goals, options: LatticeOptions) -> Scenery:
    """The scenery of a problem with at least one goal."""
    return Scenery(
        goals,
        goals.without_movables(),
        goals.with_everything(parts.problem.initial),
        distances_to(parts, goals.tools[:, :3, 3], options),
    )


def distances_to(parts: ReachingParts, points: Array, options: LatticeOptions) -> DistanceField:
    """Ways of the tool to ``points`` (k, 3) around fixtures and immovables."""
    scene, poses = parts.problem.scene, parts.problem.initial.object_poses
    still: list[tuple[Shape, Array]] = [(f.shape, f.pose) for f in scene.fixtures]
    still += [
        (item.shape, pose)
        for item, pose in zip(scene.objects, poses, strict=True)
        if item.mobility is not Mobility.MOVABLE
    ]
    home = parts.kinematics.forward(parts.problem.initial.joint_positions)[:3, 3]
    return field_to(parts.problem, home, points, still, options)


def field_to(
    problem: Problem,
    start: Array,
    points: Array,
    solids: Sequence[tuple[Shape, Array]],
    options: PrimitiveOptions,
) -> DistanceField:
    """Distances to ``points`` (k, 3) from around the workspace and ``start`` (3,)."""
    workspace = problem.scene.workspace
    corners = np.vstack([workspace.lower, workspace.upper, start, points])
    lower, upper = corners.min(axis=0) - _MARGIN, corners.max(axis=0) + _MARGIN
    field = DistanceField(lower, upper, options.resolution, solids, options.hand_radius)
    field.spread_from(points)
    return field
