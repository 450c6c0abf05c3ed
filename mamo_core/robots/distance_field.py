"""How far points around a part of the robot are from its surface, on a grid that is never wrong."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from mamo_core.types.geometry import Array

CELL = 0.0125
"""Side of a cell, m."""

HALF_DIAGONAL = CELL * math.sqrt(3.0) / 2.0
"""No point of a cell is farther from its centre, m."""

CURVATURE = 3.0 * CELL**2 / 8.0
"""How far values between centres may be above the distance, times that distance, m^2.

Linear values over a cube are above a function by no more than 3 h^2 / 8 of its largest second
derivative, and that of a distance d to whatever surface is nowhere above 1 / d.
"""

STEP = 0.001
"""What a number in a cell stands for, m; the largest is 255 of them."""

PAD = 0.125
"""How far the grid reaches beyond the surface, m: no less than the largest sphere of a cover."""

_NEAR = 0.08
_EDGE = 0.003
_REACH = _EDGE / np.sqrt(3.0)
"""No point of a triangle is further from its nearest corner than edge / sqrt(3)."""


@dataclass(frozen=True, eq=False)
class DistanceField:
    """Lower bounds of the distance to a surface, for the self-collision check.

    ``frame``: number of the link in whose frame it is, -1 for the base. ``links``: numbers of the
    links that are checked against it; a held object is checked against all fields. ``origin``
    (3,): corner of the grid. ``values`` (nx, ny, nz) uint8: the centre of a cell is no nearer to
    the surface than so many ``STEP``; 0 within what is solid. ``lower``, ``upper`` (3,): bounds of
    the surface, ``PAD`` at least inside of the grid's.
    """

    frame: int
    links: tuple[int, ...]
    origin: Array
    values: npt.NDArray[np.uint8]
    lower: Array
    upper: Array


def measure_field(
    frame: int, links: tuple[int, ...], surfaces: Sequence[Any], solids: Sequence[Any]
) -> DistanceField:
    """The field around ``surfaces`` and the convex ``solids`` (trimesh, in the frame)."""
    meshes = [*surfaces, *solids]
    samples = np.vstack([_samples(mesh) for mesh in meshes])
    lower = np.min([mesh.bounds[0] for mesh in meshes], axis=0)
    upper = np.max([mesh.bounds[1] for mesh in meshes], axis=0)
    origin = lower - PAD
    counts = np.ceil((upper + PAD - origin) / CELL).astype(int)
    axes = [origin[k] + (np.arange(counts[k]) + 0.5) * CELL for k in range(3)]
    centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    bounds = _bounds(samples, origin, tuple(counts), centres)
    for solid in solids:
        bounds[_inside(solid, centres)] = 0.0
    steps = np.floor(np.clip(bounds / STEP, 0.0, 255.0) + 1e-9).astype(np.uint8)
    return DistanceField(frame, links, origin, steps.reshape(tuple(counts)), lower, upper)


def _bounds(samples: Array, origin: Array, counts: tuple[int, ...], centres: Array) -> Array:
    """What centres of cells (k, 3) are no nearer to the surface than (k,), m; it may be below 0.

    From cell to cell at first; near the surface, where it matters, from the nearest sample.
    """
    from scipy.ndimage import distance_transform_edt
    from scipy.spatial import cKDTree

    empty = np.ones(counts, dtype=np.bool_)
    empty[tuple(np.floor((samples - origin) / CELL).astype(int).T)] = False
    # A sample stands for all within its reach, and for an occupied cell it may be at the edge.
    bounds: Array = distance_transform_edt(empty, sampling=CELL).ravel() - HALF_DIAGONAL - _REACH
    near = np.flatnonzero(bounds < _NEAR)
    distances, _ = cKDTree(samples).query(centres[near])
    bounds[near] = distances - _REACH
    return bounds


def _samples(mesh: Any) -> Array:
    """Points (k, 3) on the surface; nothing of it is farther than ``_REACH`` from all of them."""
    import trimesh

    vertices, _ = trimesh.remesh.subdivide_to_size(mesh.vertices, mesh.faces, _EDGE, max_iter=20)
    return np.unique(np.round(vertices, 6), axis=0)


def _inside(solid: Any, points: Array) -> Any:
    offsets = np.einsum("ij,ij->i", solid.face_normals, solid.triangles[:, 0])
    found = np.zeros(len(points), dtype=np.bool_)
    near = np.flatnonzero(((points >= solid.bounds[0]) & (points <= solid.bounds[1])).all(axis=1))
    found[near] = (points[near] @ solid.face_normals.T <= offsets).all(axis=1)
    return found


def write_fields(fields: Sequence[DistanceField], path: Path) -> None:
    """Write them into one file (NPZ)."""
    arrays: dict[str, Any] = {}
    for k, field in enumerate(fields):
        arrays[f"{k}.parts"] = np.array([field.frame, *field.links], dtype=np.int64)
        arrays[f"{k}.values"] = field.values
        arrays[f"{k}.bounds"] = np.array([field.origin, field.lower, field.upper])
    np.savez(path, count=np.array(len(fields)), **arrays)


def read_fields(path: Path) -> tuple[DistanceField, ...]:
    """What ``write_fields`` has written."""
    fields = []
    with np.load(path) as file:
        for k in range(int(file["count"])):
            frame, *links = file[f"{k}.parts"].tolist()
            values, bounds = file[f"{k}.values"], file[f"{k}.bounds"]
            for array in (values, bounds):
                array.flags.writeable = False
            fields.append(DistanceField(frame, tuple(links), bounds[0], values, *bounds[1:]))
    return tuple(fields)
