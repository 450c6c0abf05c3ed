"""The exact collision checker: the arm's own meshes against boxes and cylinders, by python-fcl."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionChecker, CollisionWorld, HeldObject
from mamo_core.robots.fcl_shapes import half_size, mesh_tree, placed_at, solid
from mamo_core.robots.kinematics import link_transforms_along
from mamo_core.robots.model import ArmModel
from mamo_core.robots.self_collision import SelfCollisions
from mamo_core.robots.timing import interpolated
from mamo_core.types.geometry import Array, BoolArray, IntArray, Shape, matrix_from_pose
from mamo_core.types.scene import Scene

_EDGE_STEP = 0.02
"""Edges are checked at least this often, rad of the fastest joint."""


_SLACK = 1e-9
"""Boxes closer than this (m) may touch, whatever was rounded."""


@dataclass(frozen=True, eq=False)
class _Piece:
    """Something that moves with link ``number``, and the box around it.

    ``T_link_piece`` (4, 4) places the geometry's frame, in which the box has its ``centre`` (3,)
    and ``half`` its size (3,).
    """

    number: int
    geometry: Any
    centre: Array
    half: Array
    T_link_piece: Array


@dataclass(frozen=True, eq=False)
class _Obstacle:
    """A body in the world; its frame is in the centre of the box around it, ``half`` (3,) large."""

    name: str
    shape: Shape
    T_world_obstacle: Array
    half: Array

    @cached_property
    def item(self) -> Any:
        """The fcl object; most obstacles are never asked for it."""
        import fcl

        transform = placed_at(fcl, self.T_world_obstacle)
        return fcl.CollisionObject(solid(self.shape), transform)


class ExactWorld(CollisionWorld):
    """Meshes of the arm against primitives, and against the robot's own. Slow; the authority for
    final paths.

    Pairs whose boxes are apart cannot touch and are not looked at.
    """

    def __init__(
        self,
        arm: ArmModel,
        T_world_base: Array,
        opening: float,
        obstacles: list[_Obstacle],
        pieces: list[_Piece],
        own: SelfCollisions,
    ) -> None:
        self._own = own
        self._arm, self._opening, self._T_world_base = arm, opening, T_world_base
        self._obstacles, self._pieces = obstacles, pieces
        self._links = [piece.number for piece in pieces]
        self._T_link_pieces = np.array([piece.T_link_piece for piece in pieces])[:, None]
        self._centres = np.array([piece.centre for piece in pieces])
        self._halves = np.array([piece.half for piece in pieces])
        self._T_obstacles = np.array([o.T_world_obstacle for o in obstacles]).reshape(-1, 4, 4)
        self._obstacle_halves = np.array([o.half for o in obstacles]).reshape(-1, 3)

    def free(self, configurations: Array) -> BoolArray:
        rows = np.atleast_2d(configurations)
        touched = {row for row, _ in self._touching(rows)}
        clear = np.array([row not in touched for row in range(len(rows))], dtype=np.bool_)
        clear[clear] = self._own.free(rows[clear], self._opening)
        return clear

    def edges_free(self, starts: Array, ends: Array) -> BoolArray:
        return np.array(
            [
                bool(self.free(interpolated(np.stack([a, b]), _EDGE_STEP)).all())
                for a, b in zip(np.atleast_2d(starts), np.atleast_2d(ends), strict=True)
            ]
        )

    def first_touched(self, configurations: Array) -> str | None:
        """Name of something the arm (or the held object) touches at configurations (k, dof).

        The robot itself is not asked for here: see ``SelfCollisions``.
        """
        return next((name for _, name in self._touching(np.atleast_2d(configurations))), None)

    def touching_links(self, configuration: Array) -> frozenset[int]:
        """Numbers of the links whose meshes touch something at a configuration (dof,)."""
        import fcl

        rows = configuration[None, :]
        links = link_transforms_along(self._arm, rows, self._opening)
        T_world_pieces = self._T_world_base @ (links[self._links] @ self._T_link_pieces)
        touching = set()
        for _, k, j in self._near(T_world_pieces).tolist():
            transform = placed_at(fcl, T_world_pieces[k, 0])
            piece = fcl.CollisionObject(self._pieces[k].geometry, transform)
            if fcl.collide(piece, self._obstacles[j].item):
                touching.add(self._pieces[k].number)
        return frozenset(touching)

    def _touching(self, configurations: Array) -> Iterator[tuple[int, str]]:
        """Numbers of configurations that touch something, and what; the first of each."""
        import fcl

        links = link_transforms_along(self._arm, configurations, self._opening)
        T_world_pieces = self._T_world_base @ (links[self._links] @ self._T_link_pieces)
        done = -1
        for row, k, j in self._near(T_world_pieces).tolist():
            if row == done:
                continue
            transform = placed_at(fcl, T_world_pieces[k, row])
            piece = fcl.CollisionObject(self._pieces[k].geometry, transform)
            if fcl.collide(piece, self._obstacles[j].item):
                done = row
                yield row, self._obstacles[j].name

    def _near(self, T_world_pieces: Array) -> IntArray:
        """Numbers (n, 3), ascending, of configurations, pieces and obstacles whose boxes meet."""
        R = T_world_pieces[..., :3, :3]
        centres = np.einsum("pkij,pj->pki", R, self._centres) + T_world_pieces[..., :3, 3]
        reach = np.einsum("pkij,pj->pki", np.abs(R), self._halves) + _SLACK
        R_obstacles, where = self._T_obstacles[:, :3, :3], self._T_obstacles[:, :3, 3]
        reach_obstacles = np.einsum("oij,oj->oi", np.abs(R_obstacles), self._obstacle_halves)
        close = np.ones((*centres.shape[:2], len(where)), dtype=np.bool_)
        for axis in range(3):
            gaps = np.abs(centres[:, :, None, axis] - where[:, axis])
            close &= gaps <= reach[:, :, None, axis] + reach_obstacles[:, axis]
        found = np.argwhere(close.swapaxes(0, 1))
        row, k, j = found.T
        meet = _boxes_meet(
            R[k, row],
            self._halves[k],
            R_obstacles[j],
            self._obstacle_halves[j],
            where[j] - centres[k, row],
        )
        return found[meet]


def _boxes_meet(
    R_world_one: Array, half_one: Array, R_world_other: Array, half_other: Array, way: Array
) -> BoolArray:
    """Whether oriented boxes meet, pair by pair (n,): none of 15 axes separates them.

    ``R_world_one`` (n, 3, 3) and ``half_one`` (n, 3) are the frames and half sizes, ``way`` (n, 3)
    leads from one centre to the other.
    """
    R = np.einsum("nki,nkj->nij", R_world_one, R_world_other)
    # Axes of almost parallel edges are almost nothing: the slack keeps them from separating.
    A = np.abs(R) + _SLACK
    t = np.einsum("nki,nk->ni", R_world_one, way)
    u = np.einsum("nki,nk->ni", R_world_other, way)
    meet: BoolArray = (np.abs(t) <= half_one + np.einsum("nij,nj->ni", A, half_other)).all(axis=1)
    meet &= (np.abs(u) <= half_other + np.einsum("nij,ni->nj", A, half_one)).all(axis=1)
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            j1, j2 = (j + 1) % 3, (j + 2) % 3
            reach = half_one[:, i1] * A[:, i2, j] + half_one[:, i2] * A[:, i1, j]
            reach += half_other[:, j1] * A[:, i, j2] + half_other[:, j2] * A[:, i, j1]
            meet &= np.abs(t[:, i2] * R[:, i1, j] - t[:, i1] * R[:, i2, j]) <= reach + _SLACK
    return meet


class ExactChecker(CollisionChecker):
    """Loads the meshes once; worlds share them."""

    def __init__(self, scene: Scene, arm: ArmModel) -> None:
        self._scene, self._arm = scene, arm
        self._T_world_base = matrix_from_pose(scene.T_world_base)
        self._own = SelfCollisions(arm)
        self._links = [
            _Piece(number, *mesh_tree(path), np.eye(4))
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
        own = self._own if held is None else SelfCollisions(self._arm, held)
        return ExactWorld(self._arm, self._T_world_base, opening, obstacles, pieces, own)

    def _held(self, held: HeldObject) -> _Piece:
        T = self._arm.T_link_tool @ held.T_tool_object
        geometry, half = solid(held.shape), half_size(held.shape)
        return _Piece(self._arm.tool_link, geometry, np.zeros(3), half, T)


def _obstacle(name: str, shape: Shape, pose: Array) -> _Obstacle:
    return _Obstacle(name, shape, matrix_from_pose(pose), half_size(shape))
