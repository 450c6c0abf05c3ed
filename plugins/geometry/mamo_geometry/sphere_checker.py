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
    ArmSpheres,
    ChainArrays,
    Cover,
    SphereArrays,
    WorldArrays,
    chain_arrays,
    held_cover,
    with_held,
)
from mamo_geometry.kernels import edges_batch, free_batch, hands_free, sweep_heights
from mamo_geometry.options import SphereCheckerOptions
from mamo_geometry.recent import Recent
from mamo_geometry.surroundings import Surroundings

_WORLDS, _HELD = 32, 8


class SphereWorld(CollisionWorld):
    """Arrays ready for the kernels; the compiled planner of this package reads them, too."""

    def __init__(
        self, chain: ChainArrays, spheres: SphereArrays, world: WorldArrays, T_tool_link: Array
    ) -> None:
        """``T_tool_link`` (4, 4): the last link in the tool."""
        self.chain, self.spheres, self.world = chain, spheres, world
        self._T_tool_link = T_tool_link

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
        self._T_tool_link = invert(arm.T_link_tool)
        self._surroundings = Surroundings(scene, arm)
        self._arm_spheres = ArmSpheres(arm)
        self._bare: dict[float, SphereArrays] = {}
        self._covers: dict[str, Cover] = {}
        # One state is asked about many times, and what the arm holds in several worlds.
        self._worlds: Recent[WorldArrays] = Recent(_WORLDS)
        self._loaded: Recent[SphereArrays] = Recent(_HELD)

    def world(
        self,
        object_poses: Array,
        *,
        opening: float,
        ignore: Collection[str] = (),
        held: HeldObject | None = None,
        margin: float = 0.0,
    ) -> SphereWorld:
        kept = self._options.margin + margin
        arrays = self._worlds.get(
            (object_poses.tobytes(), frozenset(ignore), kept),
            lambda: self._surroundings.world(object_poses, ignore, kept),
        )
        return SphereWorld(self._chain, self._spheres(opening, held), arrays, self._T_tool_link)

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
            self._bare[opening] = self._arm_spheres.at(opening)
        bare = self._bare[opening]
        if held is None:
            return bare
        up = None if held.up is None else held.up.tobytes()
        key = (opening, held.name, held.T_tool_object.tobytes(), up)
        return self._loaded.get(key, lambda: self._with(bare, held))

    def _with(self, bare: SphereArrays, held: HeldObject) -> SphereArrays:
        if held.name not in self._covers:
            self._covers[held.name] = held_cover(held.shape)
        T_link_object = self._arm.T_link_tool @ held.T_tool_object
        tilt = float(np.radians(self._options.max_held_tilt_deg))
        up = bare.up if held.up is None else self._arm.T_link_tool[:3, :3] @ held.up
        return with_held(bare, self._covers[held.name], T_link_object, up, tilt)


def _rows(configurations: Array) -> Array:
    """A writable copy (k, dof): read-only arrays would have every kernel compiled once more."""
    return np.array(configurations, dtype=np.float64, order="C", ndmin=2)
