"""How far a box is from being out of a region if it may turn: steps over x, y and yaw."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mamo_core.types.geometry import Array, BoolArray, IntArray, frozen_array, make_pose
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility
from mamo_planners.mapf.footprint import FootprintArrays, footprint_of, pack
from mamo_planners.mapf.maps import cells_inside, free_cells
from mamo_planners.mapf.tables import TOUCH

STEP = 0.01
"""Length of a step, m; to turn by one layer moves the corners about as far."""

NEVER = 30_000
"""Steps from where there is no way out."""

_FAR = 1.0
"""The kernels count cells from so far (m) before the workspace, where no obstacle is near."""


@dataclass(frozen=True, eq=False)
class WayOut:
    """``steps`` (nx, ny, layers) to a place outside a region; layers are yaws over half a turn.

    ``origin`` (2,): world xy of the first cell.
    """

    origin: Array
    steps: npt.NDArray[np.int16]

    def left(self, poses: Array) -> IntArray:
        """Steps (...) from ``poses`` (..., 3), as x, y and yaw; ``NEVER`` outside the lattice."""
        nx, ny, layers = self.steps.shape
        cells = np.rint((poses[..., :2] - self.origin) / STEP).astype(np.int64)
        layer = np.rint(poses[..., 2] * layers / np.pi).astype(np.int64) % layers
        known = ((cells >= 0) & (cells < (nx, ny))).all(axis=-1)
        x, y = np.clip(cells[..., 0], 0, nx - 1), np.clip(cells[..., 1], 0, ny - 1)
        return np.where(known, self.steps[x, y, layer], NEVER).astype(np.int64)


class WaysOut:
    """Of a problem's boxes, past what must not be touched and as if there were no movables."""

    def __init__(self, problem: Problem, gone: Collection[str] = ()) -> None:
        """``gone``: things that are not there."""
        self._problem = problem
        scene, poses = problem.scene, problem.initial.object_poses
        fixed = [
            i
            for i, o in enumerate(scene.objects)
            if o.mobility is not Mobility.MOVABLE and o.name not in gone
        ]
        self._obstacles = pack(
            [footprint_of(scene.objects[i].shape, poses[i]) for i in fixed],
            [poses[i][:2] for i in fixed],
        )
        self._lower, self._upper = scene.workspace.lower[:2], scene.workspace.upper[:2]
        self._open = self._lower - np.array([scene.workspace.overhang, 0.0])
        self._size = np.rint((self._upper - self._open) / STEP).astype(np.int64) + 1
        self._before = frozen_array(self._open - _FAR, "before", (2,))
        self._first = np.full(2, round(_FAR / STEP), dtype=np.int64)

    def of(self, number: int, region: SweptRegion) -> WayOut:
        """For the box that is object ``number`` of the scene, as upright as it is at first."""
        shape = self._problem.scene.objects[number].shape
        layers = max(2, int(np.ceil(np.pi * shape.footprint_radius / STEP)))
        height = float(self._problem.initial.object_poses[number][2])
        yaws = np.arange(layers) * (np.pi / layers)
        turned = [footprint_of(shape, make_pose([*self._before, height], yaw)) for yaw in yaws]
        shapes = pack(turned, [self._before] * layers)
        free = np.stack([self._free(shapes, n) for n in range(layers)], axis=2)
        outside = np.stack([self._outside(shapes, n, region) for n in range(layers)], axis=2)
        return WayOut(self._open, _spread(free, free & outside))

    def _free(self, shapes: FootprintArrays, layer: int) -> BoolArray:
        """Where (nx, ny) the box may pass."""
        clear: BoolArray = free_cells(
            layer, shapes, self._obstacles, 0.0, self._first, self._size, STEP
        )
        return clear & self._within(shapes, layer, self._open)

    def _outside(self, shapes: FootprintArrays, layer: int, region: SweptRegion) -> BoolArray:
        """Where (nx, ny) the box is out of the region and need not reach over the open front."""
        inside: BoolArray = cells_inside(
            self._before,
            shapes.points[layer],
            shapes.radius[layer],
            shapes.top[layer],
            region.origin,
            region.resolution,
            region.lowest,
            self._first,
            self._size,
            STEP,
        )
        return self._within(shapes, layer, self._lower) & ~inside

    def _within(self, shapes: FootprintArrays, layer: int, lower: Array) -> BoolArray:
        """Where (nx, ny) the footprint is between ``lower`` (2,) and the upper bounds."""
        reach = np.abs(shapes.points[layer]).max(axis=0)
        x, y = (self._open[axis] + np.arange(self._size[axis]) * STEP for axis in range(2))
        low, high = lower + reach - TOUCH, self._upper - reach + TOUCH
        return ((x >= low[0]) & (x <= high[0]))[:, None] & ((y >= low[1]) & (y <= high[1]))


def _spread(free: BoolArray, ends: BoolArray) -> npt.NDArray[np.int16]:
    """Steps (nx, ny, layers) to ``ends`` through what is ``free``; one more next to that.

    Real boxes touch what they stand beside, and so are in cells that are not free.
    """
    steps = np.full(free.shape, NEVER, dtype=np.int16)
    front, reached = ends, 0
    while front.any():
        steps[front] = reached
        reached += 1
        beside = _beside(front) & (steps == NEVER)
        steps[beside & ~free] = reached
        front = beside & free
    return steps


def _beside(cells: BoolArray) -> BoolArray:
    """Cells one step from some; after the last layer comes the first."""
    found: BoolArray = np.roll(cells, 1, axis=2) | np.roll(cells, -1, axis=2)
    found[1:] |= cells[:-1]
    found[:-1] |= cells[1:]
    found[:, 1:] |= cells[:, :-1]
    found[:, :-1] |= cells[:, 1:]
    return found
