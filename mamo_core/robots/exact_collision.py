"""The exact collision checker: the arm's own meshes against boxes and cylinders, by python-fcl."""

from __future__ import annotations

from collections.abc import Collection
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionChecker, CollisionWorld, HeldObject
from mamo_core.robots.kinematics import link_transforms
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import interpolated
from mamo_core.types.geometry import Array, BoolArray, Box, Shape, matrix_from_pose
from mamo_core.types.scene import Scene

_EDGE_STEP = 0.02
"""Edges are checked at least this often, rad of the fastest joint."""


class ExactWorld(CollisionWorld):
    """Meshes of the arm against primitives. Slow; the authority for final paths."""

    def __init__(
        self,
        arm: ArmModel,
        T_world_base: Array,
        opening: float,
        obstacles: list[tuple[str, Any, Any]],
        links: list[tuple[int, Any]],
        held: HeldObject | None,
    ) -> None:
        import fcl

        self._fcl, self._arm, self._opening, self._held = fcl, arm, opening, held
        self._T_world_base = T_world_base
        self._obstacles = fcl.DynamicAABBTreeCollisionManager()
        self._obstacles.registerObjects([fcl.CollisionObject(g, T) for _, g, T in obstacles])
        self._obstacles.setup()
        self._names = {id(geometry): name for name, geometry, _ in obstacles}
        self._geometries = [geometry for _, geometry, _ in obstacles]
        self._links = links
        moving = [item for _, item in links]
        if held is not None:
            self._held_item = fcl.CollisionObject(_geometry(fcl, held.shape))
            moving = [*moving, self._held_item]
        self._moving = fcl.DynamicAABBTreeCollisionManager()
        self._moving.registerObjects(moving)
        self._moving.setup()

    def free(self, configurations: Array) -> BoolArray:
        return np.array([self.touching(q) is None for q in np.atleast_2d(configurations)])

    def edges_free(self, starts: Array, ends: Array) -> BoolArray:
        return np.array(
            [
                bool(self.free(interpolated(np.stack([a, b]), _EDGE_STEP)).all())
                for a, b in zip(np.atleast_2d(starts), np.atleast_2d(ends), strict=True)
            ]
        )

    def touching(self, configuration: Array) -> str | None:
        """Name of something the arm (or the held object) touches at ``configuration`` (dof,)."""
        fcl = self._fcl
        transforms = link_transforms(self._arm, configuration, self._opening)
        for number, item in self._links:
            item.setTransform(_fcl_transform(fcl, self._T_world_base @ transforms[number]))
        if self._held is not None:
            T_tool = self._T_world_base @ transforms[self._arm.tool_link] @ self._arm.T_link_tool
            T = T_tool @ self._held.T_tool_object
            self._held_item.setTransform(_fcl_transform(fcl, T))
        self._moving.update()
        data = fcl.CollisionData()
        self._moving.collide(self._obstacles, data, fcl.defaultCollisionCallback)
        if not data.result.is_collision:
            return None
        contact = data.result.contacts[0] if data.result.contacts else None
        for geometry in (contact.o1, contact.o2) if contact is not None else ():
            if id(geometry) in self._names:
                return self._names[id(geometry)]
        return "something"


class ExactChecker(CollisionChecker):
    """Loads the meshes once; worlds share them, so one world at a time is checked."""

    def __init__(self, scene: Scene, arm: ArmModel) -> None:
        self._scene, self._arm = scene, arm
        self._T_world_base = matrix_from_pose(scene.T_world_base)
        self._meshes = [
            (number, _mesh(path)) for number, link in enumerate(arm.links) for path in link.meshes
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
        import fcl

        if margin > 0.0:
            raise ValueError(f"margin: {margin}, the exact checker keeps none (expected 0)")
        bodies = [(f.name, f.shape, f.pose) for f in self._scene.fixtures]
        bodies += [
            (o.name, o.shape, pose)
            for o, pose in zip(self._scene.objects, object_poses, strict=True)
        ]
        obstacles = [
            (name, _geometry(fcl, shape), _fcl_pose(fcl, pose))
            for name, shape, pose in bodies
            if name not in ignore
        ]
        links = [(number, fcl.CollisionObject(mesh)) for number, mesh in self._meshes]
        return ExactWorld(self._arm, self._T_world_base, opening, obstacles, links, held)


def _geometry(fcl: Any, shape: Shape) -> Any:
    if isinstance(shape, Box):
        return fcl.Box(*shape.size)
    return fcl.Cylinder(shape.radius, shape.height)


@cache
def _mesh(path: Path) -> Any:
    """The mesh as a tree; built once, it never changes."""
    import fcl
    import trimesh

    mesh = trimesh.load(path, force="mesh")
    model = fcl.BVHModel()
    model.beginModel(len(mesh.vertices), len(mesh.faces))
    model.addSubModel(mesh.vertices, mesh.faces)
    model.endModel()
    return model


def _fcl_transform(fcl: Any, T: Array) -> Any:
    return fcl.Transform(np.ascontiguousarray(T[:3, :3]), np.ascontiguousarray(T[:3, 3]))


def _fcl_pose(fcl: Any, pose: Array) -> Any:
    return _fcl_transform(fcl, matrix_from_pose(pose))
