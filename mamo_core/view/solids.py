"""What stands in a scene as triangle meshes, in its own frame, metres."""

from __future__ import annotations

from typing import Any

import numpy as np

from mamo_core.robots.model import BodyPart, LinkModel
from mamo_core.types.geometry import Array, Box, IntArray, Shape
from mamo_core.types.region import SweptRegion

_SECTIONS = 48
"""Sides of what stands for a cylinder."""

_SIDES = (
    ((1, 0), ((1, 0), (1, 1))),
    ((-1, 0), ((0, 1), (0, 0))),
    ((0, 1), ((1, 1), (0, 1))),
    ((0, -1), ((0, 0), (1, 0))),
)
"""Of a cell: where the neighbour is, and the edge to it, the cell on its left."""


def shape_mesh(shape: Shape) -> Any:
    """A ``trimesh.Trimesh`` of a box or cylinder about its centre."""
    import trimesh

    if isinstance(shape, Box):
        return trimesh.creation.box(extents=shape.size)
    return trimesh.creation.cylinder(shape.radius, shape.height, sections=_SECTIONS)


def part_mesh(part: LinkModel | BodyPart) -> Any | None:
    """A ``trimesh.Trimesh`` of all surfaces of a part in its frame; None if it has none."""
    import trimesh

    if not part.meshes:
        return None
    parts = [trimesh.load(path, force="mesh") for path in part.meshes]
    return trimesh.util.concatenate(parts)


def region_mesh(region: SweptRegion, top: float) -> Any | None:
    """A closed ``trimesh.Trimesh`` of the swept space below ``top`` (m) in the world.

    None if nothing is swept there. There are no walls inside, which would show through.
    """
    import trimesh

    bottom = np.minimum(np.maximum(region.lowest, region.floor), top)
    cells = np.argwhere(bottom < top)
    if not len(cells):
        return None
    padded = np.pad(bottom, 1, constant_values=top)
    height = bottom[tuple(cells.T)]
    ceiling = np.full(len(cells), top)
    corners = [cells + corner for corner in ((0, 0), (1, 0), (1, 1), (0, 1))]
    quads = [
        _quads(region, corners, [ceiling] * 4),
        _quads(region, corners[::-1], [height] * 4),
    ]
    for (di, dj), edge in _SIDES:
        beyond = padded[cells[:, 0] + 1 + di, cells[:, 1] + 1 + dj]
        open_ = beyond > height
        low, high = height[open_], beyond[open_]
        left, right = (cells[open_] + corner for corner in edge)
        quads.append(_quads(region, [left, right, right, left], [low, low, high, high]))
    vertices = np.concatenate(quads)
    firsts = 4 * np.arange(len(vertices) // 4)[:, None]
    faces = np.concatenate([firsts + np.array(half) for half in ((0, 1, 2), (0, 2, 3))])
    return trimesh.Trimesh(vertices, faces)


def _quads(region: SweptRegion, corners: list[IntArray], heights: list[Array]) -> Array:
    """Vertices (4 k, 3) of quadrilaterals: lattice corners (k, 2) and heights (k,), four each."""
    points = np.stack(
        [
            np.column_stack([region.origin + corner * region.resolution, height])
            for corner, height in zip(corners, heights, strict=True)
        ],
        axis=1,
    )
    return points.reshape(-1, 3)
