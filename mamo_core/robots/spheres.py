"""Conservative sphere covers: every point of a convex hull's surface lies in some sphere."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.distance import cdist

from mamo_core.types.geometry import Array

_EDGE_SHARE = 0.7
# No point of a triangle is further from its nearest corner than edge / sqrt(3).
_REACH_SHARE = _EDGE_SHARE / np.sqrt(3.0)

_AT_ONCE = 1_000
"""All distances at once would take gigabytes."""


def cover_hull(hull: Any, slack: float) -> Array:
    """Spheres (k, 4) x, y, z, r that cover the surface of a convex trimesh.

    Greedy set cover: candidate centres are grid points inside, each with the radius of its
    inscribed ball plus ``slack`` (m), the most a sphere may stick out of the hull.
    """
    samples = _surface_samples(hull, _EDGE_SHARE * slack)
    inner, depth = _inner_points(hull, step=slack)
    # Samples are candidates, too: sharp corners are out of reach from the inside.
    centres = np.vstack([inner, samples])
    inscribed = np.concatenate([depth, np.zeros(len(samples))])
    radii = inscribed + slack
    # Samples by candidates: what a choice changes are rows.
    covered = np.empty((len(samples), len(centres)), dtype=np.bool_)
    for at in range(0, len(samples), _AT_ONCE):
        distances = cdist(samples[at : at + _AT_ONCE], centres)
        covered[at : at + _AT_ONCE] = distances <= (radii - _REACH_SHARE * slack)[None, :]
    if not covered.any(axis=1).all():
        raise ValueError(f"sphere cover: slack {slack} m is too small for this hull")
    chosen: list[int] = []
    missing = np.ones(len(samples), dtype=np.bool_)
    gains = covered.sum(axis=0)
    while missing.any():
        best = int(np.argmax(gains))
        chosen.append(best)
        new = missing & covered[:, best]
        gains -= covered[new].sum(axis=0)
        missing &= ~new
    return np.column_stack([centres[chosen], radii[chosen]])


def _surface_samples(hull: Any, edge: float) -> Array:
    import trimesh

    vertices, _ = trimesh.remesh.subdivide_to_size(hull.vertices, hull.faces, edge)
    return np.unique(np.round(vertices, 6), axis=0)


def _inner_points(hull: Any, step: float) -> tuple[Array, Array]:
    """Grid points (m, 3) inside a convex hull and their distances (m,) to its surface."""
    lower, upper = hull.bounds
    # Half a step inwards, and never fewer than one layer, so that thin hulls have points, too.
    axes = []
    for low, high in zip(lower, upper, strict=True):
        count = max(1, int(np.ceil((high - low) / step)))
        axes.append(low + (np.arange(count) + 0.5) * (high - low) / count)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    offsets = np.einsum("ij,ij->i", hull.face_normals, hull.triangles[:, 0])
    depth = (offsets[None, :] - grid @ hull.face_normals.T).min(axis=1)
    inside = depth > 0.0
    return grid[inside], depth[inside]
