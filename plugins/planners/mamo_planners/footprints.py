"""Exact overlap of standing objects seen from above."""

from __future__ import annotations

import numpy as np

from mamo_core.types.geometry import Array, Box, Shape, footprint_corners, yaw_of


def extent_along(shape: Shape, pose: Array, direction: Array) -> float:
    """Distance (m) from the centre to the footprint's edge along a unit ``direction`` (2,)."""
    if not isinstance(shape, Box):
        return shape.radius
    yaw = yaw_of(pose)
    c, s = np.cos(yaw), np.sin(yaw)
    u = abs(c * direction[0] + s * direction[1])
    v = abs(-s * direction[0] + c * direction[1])
    sides = [shape.size[k] / 2.0 / w for k, w in ((0, u), (1, v)) if w > 1e-9]
    return float(min(sides))


def free_slide(
    shape: Shape, pose: Array, moves: Array, obstacles: list[Array], lower: Array, upper: Array
) -> int:
    """How many of ``moves`` (m, 2), in order, keep the footprint clear and within the bounds.

    ``obstacles``: convex outlines (k, 2). The outline of a cylinder is circumscribed.
    """
    corners = footprint_corners(shape, pose)
    for count, move in enumerate(moves):
        moved = corners + move
        if (moved.min(axis=0) < lower).any() or (moved.max(axis=0) > upper).any():
            return count
        if any(overlap(moved, other) for other in obstacles):
            return count
    return len(moves)


def overlap(a: Array, b: Array) -> bool:
    """Whether two convex outlines (k, 2) share area (separating axes)."""
    if (a.min(axis=0) > b.max(axis=0)).any() or (b.min(axis=0) > a.max(axis=0)).any():
        return False
    for polygon in (a, b):
        edges = np.roll(polygon, -1, axis=0) - polygon
        normals = np.stack([-edges[:, 1], edges[:, 0]], axis=1)
        pa, pb = a @ normals.T, b @ normals.T
        if ((pa.min(axis=0) > pb.max(axis=0)) | (pb.min(axis=0) > pa.max(axis=0))).any():
            return False
    return True
