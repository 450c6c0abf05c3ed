"""The conservative collision checker: sphere covers against boxes and cylinders."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionChecker, CollisionWorld, HeldObject
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, BoolArray, invert, matrix_from_pose
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Scene
from mamo_geometry.arrays import (
    ChainArrays,
    Cover,
    SphereArrays,
    WorldArrays,
    chain_arrays,
    held_cover,
    sphere_arrays,
    with_held,
    world_arrays,
)
from mamo_geometry.kernels import edges_batch, free_batch, hands_free, sweep_heights
from mamo_geometry.options import SphereCheckerOptions


class SphereWorld(CollisionWorld):
    """Arrays ready for the kernels; the compiled planner of this package reads them, too."""

    def __init__(self, chain: ChainArrays, spheres: SphereArrays, world: WorldArrays) -> None:
        self.chain, self.spheres, self.world = chain, spheres, world
        self._T_tool_link = invert(np.vstack([chain.tool, [0.0, 0.0, 0.0, 1.0]]))

    def free(self, configurations: Array) -> BoolArray:
        return free_batch(self.chain, self.spheres, self.world, _rows(configurations))

    def edges_free(self, starts: Array, ends: Array) -> BoolArray:
        return edges_batch(self.chain, self.spheres, self.world, _rows(starts), _rows(ends))

    def hands_free(self, T_world_tools: Array) -> BoolArray:
        frames = T_world_tools @ self._T_tool_link
        return hands_free(self.spheres, self.world, np.ascontiguousarray(frames))


class SphereChecker(CollisionChecker):
    """Conservative: the spheres cover every hull and mesh of the arm."""

    def __init__(self, scene: Scene, arm: ArmModel, options: SphereCheckerOptions) -> None:
        self._scene, self._arm, self._options = scene, arm, options
        self._chain = chain_arrays(arm, matrix_from_pose(scene.T_world_base))
        self._bare: dict[float, SphereArrays] = {}
        self._covers: dict[str, Cover] = {}

    def world(
        self,
        object_poses: Array,
        *,
        opening: float,
        ignore: Collection[str] = (),
        held: HeldObject | None = None,
        margin: float = 0.0,
    ) -> SphereWorld:
        arrays = world_arrays(
            self._scene, self._arm, object_poses, ignore, self._options.margin + margin
        )
        return SphereWorld(self._chain, self._spheres(opening, held), arrays)

    def swept_region(
        self, path: Array, *, opening: float, held: HeldObject | None = None
    ) -> SweptRegion:
        region = self._empty_region()
        lowest = np.array(region.lowest)
        sweep_heights(
            self._chain,
            self._spheres(opening, held),
            _rows(path),
            np.array(region.origin),
            region.resolution,
            lowest,
        )
        return SweptRegion(region.origin, region.resolution, lowest, region.floor)

    def _empty_region(self) -> SweptRegion:
        """Covers the workspace and a border, for objects that overhang the front."""
        workspace, cell = self._scene.workspace, self._options.region_resolution
        border = workspace.overhang + 0.15
        lower = workspace.lower[:2] - border
        shape = np.ceil((workspace.upper[:2] + border - lower) / cell).astype(int)
        return SweptRegion(lower, cell, np.full(tuple(shape), np.inf), workspace.floor)

    def _spheres(self, opening: float, held: HeldObject | None) -> SphereArrays:
        if opening not in self._bare:
            self._bare[opening] = sphere_arrays(self._arm, opening)
        bare = self._bare[opening]
        if held is None:
            return bare
        if held.name not in self._covers:
            self._covers[held.name] = held_cover(held.shape)
        T_link_object = self._arm.T_link_tool @ held.T_tool_object
        tilt = float(np.radians(self._options.max_held_tilt_deg))
        up = bare.up if held.up is None else self._arm.T_link_tool[:3, :3] @ held.up
        return with_held(bare, self._covers[held.name], T_link_object, up, tilt)


def _rows(configurations: Array) -> Array:
    """A writable copy (k, dof): read-only arrays would have every kernel compiled once more."""
    return np.array(np.atleast_2d(configurations), dtype=np.float64, order="C")
