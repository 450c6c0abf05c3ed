"""The exact collision checker: the arm's own meshes against boxes and cylinders, by python-fcl."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionChecker, CollisionWorld, HeldObject
from mamo_core.robots.kinematics import link_transforms_along
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import interpolated
from mamo_core.types.geometry import Array, BoolArray, Box, Shape, matrix_from_pose
from mamo_core.types.scene import Scene

_EDGE_STEP = 0.02
"""Edges are checked at least this often, rad of the fastest joint."""


@dataclass(frozen=True, eq=False)
class _Piece:
    """Something that moves with link ``number``: its geometry and box ``lower``, ``upper`` (3,).

    ``T_link_piece`` (4, 4) places the geometry's frame.
    """

    number: int
    geometry: Any
    lower: Array
    upper: Array
    T_link_piece: Array


@dataclass(frozen=True, eq=False)
class _Obstacle:
    """``name`` and an fcl object, with its box ``lower``, ``upper`` (3,) in the world."""

    name: str
    item: Any
    lower: Array
    upper: Array


class ExactWorld(CollisionWorld):
    """Meshes of the arm against primitives. Slow; the authority for final paths.

    Pairs whose axis-aligned boxes are apart cannot touch and are not looked at.
    """

    def __init__(
        self,
        arm: ArmModel,
        T_world_base: Array,
        opening: float,
        obstacles: list[_Obstacle],
        pieces: list[_Piece],
    ) -> None:
        self._arm, self._opening, self._T_world_base = arm, opening, T_world_base
        self._obstacles, self._pieces = obstacles, pieces
        self._lower = np.array([obstacle.lower for obstacle in obstacles]).reshape(-1, 3)
        self._upper = np.array([obstacle.upper for obstacle in obstacles]).reshape(-1, 3)

    def free(self, configurations: Array) -> BoolArray:
        rows = np.atleast_2d(configurations)
        touched = {row for row, _ in self._touching(rows)}
        return np.array([row not in touched for row in range(len(rows))])

    def edges_free(self, starts: Array, ends: Array) -> BoolArray:
        return np.array(
            [
                bool(self.free(interpolated(np.stack([a, b]), _EDGE_STEP)).all())
                for a, b in zip(np.atleast_2d(starts), np.atleast_2d(ends), strict=True)
            ]
        )

    def first_touched(self, configurations: Array) -> str | None:
        """Name of something the arm (or the held object) touches at configurations (k, dof)."""
        return next((name for _, name in self._touching(np.atleast_2d(configurations))), None)

    def _touching(self, configurations: Array) -> Iterator[tuple[int, str]]:
        """Numbers of configurations that touch something, and what; the first of each."""
        import fcl

        links = link_transforms_along(self._arm, configurations, self._opening)
        T_pieces = np.array([links[p.number] @ p.T_link_piece for p in self._pieces])
        T_world_pieces = self._T_world_base @ T_pieces
        close = self._close(T_world_pieces)
        for row in np.flatnonzero(close.any(axis=(0, 2))):
            for k, j in np.argwhere(close[:, row]):
                T, obstacle = T_world_pieces[k, row], self._obstacles[j]
                piece = fcl.CollisionObject(self._pieces[k].geometry, _fcl_transform(fcl, T))
                if fcl.collide(piece, obstacle.item):
                    yield int(row), obstacle.name
                    break

    def _close(self, T_world_pieces: Array) -> BoolArray:
        """Whether the boxes of pieces and obstacles overlap: (pieces, k, obstacles)."""
        lower = np.array([piece.lower for piece in self._pieces])[:, None, :]
        upper = np.array([piece.upper for piece in self._pieces])[:, None, :]
        centres = np.einsum("pkij,pkj->pki", T_world_pieces[..., :3, :3], (lower + upper) / 2.0)
        centres = centres + T_world_pieces[..., :3, 3]
        halves = np.einsum(
            "pkij,pkj->pki", np.abs(T_world_pieces[..., :3, :3]), (upper - lower) / 2.0
        )
        below = (centres - halves)[:, :, None, :] <= self._upper
        above = (centres + halves)[:, :, None, :] >= self._lower
        overlap: BoolArray = (below & above).all(axis=-1)
        return overlap


class ExactChecker(CollisionChecker):
    """Loads the meshes once; worlds share them."""

    def __init__(self, scene: Scene, arm: ArmModel) -> None:
        self._scene, self._arm = scene, arm
        self._T_world_base = matrix_from_pose(scene.T_world_base)
        self._links = [
            _Piece(number, *_mesh(path), np.eye(4))
            for number, link in enumerate(arm.links)
            for path in link.meshes
        ]

    def world(
        self,
        object_poses: Array,
        *,
        opening: float,
        ignore: Collection[str] = (),
        held: HeldObject | None = None,
        margin: float = 0.0,
    ) -> ExactWorld:
        if margin > 0.0:
            raise ValueError(f"margin: {margin}, the exact checker keeps none (expected 0)")
        bodies = [(f.name, f.shape, f.pose) for f in self._scene.fixtures]
        bodies += [
            (o.name, o.shape, pose)
            for o, pose in zip(self._scene.objects, object_poses, strict=True)
        ]
        obstacles = [_obstacle(*body) for body in bodies if body[0] not in ignore]
        pieces = self._links if held is None else [*self._links, self._held(held)]
        return ExactWorld(self._arm, self._T_world_base, opening, obstacles, pieces)

    def _held(self, held: HeldObject) -> _Piece:
        T = self._arm.T_link_tool @ held.T_tool_object
        half = _half_size(held.shape)
        return _Piece(self._arm.tool_link, _geometry(held.shape), -half, half, T)


def _obstacle(name: str, shape: Shape, pose: Array) -> _Obstacle:
    import fcl

    T = matrix_from_pose(pose)
    reach = np.abs(T[:3, :3]) @ _half_size(shape)
    item = fcl.CollisionObject(_geometry(shape), _fcl_transform(fcl, T))
    return _Obstacle(name, item, T[:3, 3] - reach, T[:3, 3] + reach)


def _half_size(shape: Shape) -> Array:
    if isinstance(shape, Box):
        return shape.size / 2.0
    return np.array([shape.radius, shape.radius, shape.height / 2.0])


def _geometry(shape: Shape) -> Any:
    import fcl

    if isinstance(shape, Box):
        return fcl.Box(*shape.size)
    return fcl.Cylinder(shape.radius, shape.height)


@cache
def _mesh(path: Path) -> tuple[Any, Array, Array]:
    """The mesh as a tree, built once as it never changes, and its box."""
    import fcl
    import trimesh

    mesh = trimesh.load(path, force="mesh")
    model = fcl.BVHModel()
    model.beginModel(len(mesh.vertices), len(mesh.faces))
    model.addSubModel(mesh.vertices, mesh.faces)
    model.endModel()
    vertices = np.asarray(mesh.vertices)
    return model, vertices.min(axis=0), vertices.max(axis=0)


def _fcl_transform(fcl: Any, T: Array) -> Any:
    return fcl.Transform(np.ascontiguousarray(T[:3, :3]), np.ascontiguousarray(T[:3, 3]))
