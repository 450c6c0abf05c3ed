"""Exact overlap of standing objects seen from above."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mamo_core.types.geometry import Array, BoolArray, Box, Shape, footprint_corners, yaw_of


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


def grown(shape: Shape, margin: float) -> Shape:
    """The shape with ``margin`` (m) around it, as seen from above."""
    if isinstance(shape, Box):
        return Box(shape.size + 2.0 * margin * np.array([1.0, 1.0, 0.0]))
    return replace(shape, radius=shape.radius + margin)


class Outlines:
    """Convex outlines (k, 2) that stand still, ready to be compared with many that do not."""

    def __init__(self, outlines: Sequence[Array]) -> None:
        self._low = np.array([o.min(axis=0) for o in outlines]).reshape(-1, 2)
        self._high = np.array([o.max(axis=0) for o in outlines]).reshape(-1, 2)
        sizes = np.array([len(o) for o in outlines], dtype=np.int64)
        # Outlines with the same number of corners are compared in one computation.
        self._groups = [
            (numbers, np.array([outlines[i] for i in numbers.tolist()]))
            for numbers in (np.flatnonzero(sizes == size) for size in np.unique(sizes))
        ]

    def overlapped(self, moved: Array, relevant: BoolArray | None = None) -> BoolArray:
        """Which of the outlines ``moved`` (m, k, 2) overlap one of these: bool (m,).

        ``relevant`` (m, n): the pairs that are looked at, if not all.
        """
        low, high = moved.min(axis=1)[:, None], moved.max(axis=1)[:, None]
        near = ((low <= self._high) & (self._low <= high)).all(axis=2)
        if relevant is not None:
            near &= relevant
        found = np.zeros(len(moved), dtype=np.bool_)
        for numbers, outlines in self._groups:
            # What overlaps one of them is not looked at again.
            mine, theirs = np.nonzero(near[:, numbers] & ~found[:, None])
            if len(mine):
                hit = ~_separated(moved[mine], outlines[theirs])
                found[mine[hit]] = True
        return found


def free_slide(
    shape: Shape, pose: Array, moves: Array, obstacles: Outlines, lower: Array, upper: Array
) -> int:
    """How many of ``moves`` (m, 2), in order, keep the footprint clear and within the bounds.

    The outline of a cylinder is circumscribed.
    """
    moved = footprint_corners(shape, pose) + moves[:, None]
    outside = (moved.min(axis=1) < lower) | (moved.max(axis=1) > upper)
    blocked = outside.any(axis=1) | obstacles.overlapped(moved)
    return int(np.argmax(blocked)) if blocked.any() else len(moves)


def overlap(a: Array, b: Array) -> bool:
    """Whether two convex outlines (k, 2) share area (separating axes)."""
    if (a.min(axis=0) > b.max(axis=0)).any() or (b.min(axis=0) > a.max(axis=0)).any():
        return False
    return not _separated(a[None], b[None])[0]


def _separated(a: Array, b: Array) -> BoolArray:
    """Whether an edge of the convex outlines ``a`` (m, i, 2) or ``b`` (m, j, 2) parts the two."""
    parted = np.zeros(len(a), dtype=np.bool_)
    for polygons in (a, b):
        normals = np.empty_like(polygons)
        following = np.concatenate([polygons[:, 1:], polygons[:, :1]], axis=1)
        normals[..., 0] = -(following[..., 1] - polygons[..., 1])
        normals[..., 1] = following[..., 0] - polygons[..., 0]
        across = normals.swapaxes(1, 2)
        pa, pb = a @ across, b @ across
        gap = (pa.min(axis=1) > pb.max(axis=1)) | (pb.min(axis=1) > pa.max(axis=1))
        parted |= gap.any(axis=1)
    return parted
