"""Shapes and meshes as python-fcl knows them."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from mamo_core.types.geometry import Array, Box, Shape


def half_size(shape: Shape) -> Array:
    """Half the size (3,) of the box around a shape, m."""
    if isinstance(shape, Box):
        return shape.size / 2.0
    return np.array([shape.radius, shape.radius, shape.height / 2.0])


def solid(shape: Shape) -> Any:
    """The shape as fcl knows it."""
    import fcl

    if isinstance(shape, Box):
        return fcl.Box(*shape.size)
    return fcl.Cylinder(shape.radius, shape.height)


@cache
def mesh_tree(path: Path) -> tuple[Any, Array, Array]:
    """The mesh as a tree, built once as it never changes, and its box: centre and half size."""
    import fcl
    import trimesh

    mesh = trimesh.load(path, force="mesh")
    model = fcl.BVHModel()
    model.beginModel(len(mesh.vertices), len(mesh.faces))
    model.addSubModel(mesh.vertices, mesh.faces)
    model.endModel()
    lower, upper = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    return model, (lower + upper) / 2.0, (upper - lower) / 2.0


def placed_at(fcl: Any, T: Array) -> Any:
    """``T`` (4, 4) as fcl wants it."""
    return fcl.Transform(np.ascontiguousarray(T[:3, :3]), np.ascontiguousarray(T[:3, 3]))
