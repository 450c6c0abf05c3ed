"""How far apart two standing objects are, as half-planes, and where one object may be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mamo_core.types.geometry import Array, Box, Cylinder, Shape, footprint_corners
from mamo_core.types.mapf import MAPFAgent, MAPFProblem

_TOUCHING = 1e-9
"""Rounding of distances, m."""


@dataclass(frozen=True, eq=False)
class Gap:
    """A lower bound of the distance (m) of two convex outlines, by where one is from the other.

    The largest distance along a normal of either outline, ``normals`` (k, 2) and ``offsets`` (k,).
    """

    normals: Array
    offsets: Array

    @classmethod
    def between(cls, shape: Shape, pose: Array, other: Shape, other_pose: Array) -> Gap:
        """Of two upright objects at poses (7,); cylinders are taken as polygons around them."""
        a = footprint_corners(shape, pose) - pose[:2]
        b = footprint_corners(other, other_pose) - other_pose[:2]
        normals = np.concatenate([_normals(b), -_normals(a)])
        return cls(normals, (a @ normals.T).min(axis=0) - (b @ normals.T).max(axis=0))

    def at(self, displacement: Array) -> float:
        """The bound for the first one at ``displacement`` (2,) from the other one."""
        return float((self.normals @ displacement + self.offsets).max())


def _normals(outline: Array) -> Array:
    """Outward unit normals (k, 2) of a convex outline (k, 2), counterclockwise."""
    edges = np.roll(outline, -1, axis=0) - outline
    return np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1)[:, None]


def same_height(shape: Shape, pose: Array, other: Shape, other_pose: Array) -> bool:
    """Whether the heights of two upright objects overlap."""
    return abs(float(pose[2] - other_pose[2])) < (shape.height + other.height) / 2.0


class Ground:
    """Where one agent may stand on its lattice, other agents aside."""

    def __init__(self, problem: MAPFProblem, agent: MAPFAgent) -> None:
        self._problem, self._agent = problem, agent
        self._here = agent.pose[:2]
        outline = footprint_corners(agent.shape, agent.pose)
        self._low, self._high = outline.min(axis=0), outline.max(axis=0)
        self._obstacles = [
            (Gap.between(agent.shape, agent.pose, o.shape, o.pose), o.pose[:2])
            for o in problem.obstacles
            if same_height(agent.shape, agent.pose, o.shape, o.pose)
        ]

    def passable(self, shift: Array) -> bool:
        """Whether it may pass where ``shift`` (2,) m brings it. It may always stay at its start."""
        lower = np.minimum(self._problem.transit_lower, self._low)
        upper = np.maximum(self._problem.transit_upper, self._high)
        if not self._within(shift, lower, upper):
            return False
        least = self._problem.margin - _TOUCHING
        return not shift.any() or all(
            gap.at(self._here + shift - place) >= least for gap, place in self._obstacles
        )

    def goal_cost(self, shift: Array) -> float:
        """What it costs to end there, in lattice steps; infinite where it may not."""
        pose = np.array(self._agent.pose)
        pose[:2] += shift
        if shift.any() and not self._within(
            shift, self._problem.goal_lower, self._problem.goal_upper
        ):
            return np.inf
        margin = self._problem.goal_margin if shift.any() else 0.0
        if self._problem.region.overlaps(_widened(self._agent.shape, margin), pose):
            return np.inf
        return sum(
            penalty.cost
            for penalty in self._agent.penalties
            if np.linalg.norm(pose[:2] - penalty.position) <= penalty.radius + _TOUCHING
        )

    def step_cost(self, shift: Array) -> float:
        """What a step that arrives there costs."""
        field = self._agent.cost_field
        if field is None:
            return 1.0
        i, j = np.floor((self._here + shift - field.origin) / field.resolution + 1e-9).astype(int)
        inside = 0 <= i < field.values.shape[0] and 0 <= j < field.values.shape[1]
        return 1.0 + (float(field.values[i, j]) if inside else 0.0)

    def _within(self, shift: Array, lower: Array, upper: Array) -> bool:
        return bool(
            (self._low + shift >= lower - _TOUCHING).all()
            and (self._high + shift <= upper + _TOUCHING).all()
        )


def _widened(shape: Shape, margin: float) -> Shape:
    """The shape with ``margin`` (m) around its footprint."""
    if isinstance(shape, Box):
        return Box(shape.size + np.array([2.0 * margin, 2.0 * margin, 0.0]))
    return Cylinder(shape.radius + margin, shape.height)
