"""The negative goal region (NGR): the space a retrieval sweeps, where no movable may stay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mamo_core.types.geometry import Array, BoolArray, Box, Shape, frozen_array, yaw_of

_BORDER = 3.0
"""Cells looked at beyond the circle around a footprint: a diagonal, and rounding."""


@dataclass(frozen=True, eq=False)
class SweptRegion:
    """Height map of a swept volume over standing objects (thesis 4.4, Dogar's NGR).

    ``lowest`` (nx, ny): lowest swept height (m, world) over each square cell of ``resolution``
    metres, +inf where nothing passes. Cell (i, j) covers
    ``origin + [i, i + 1] x [j, j + 1] * resolution``. It is conservative: a cell counts the whole
    sweep over any part of it. ``floor``: height (m) the objects stand on.
    """

    origin: Array
    resolution: float
    lowest: npt.NDArray[np.float64]
    floor: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", frozen_array(self.origin, "region origin", (2,)))
        lowest = np.array(self.lowest, dtype=np.float64)
        lowest.flags.writeable = False
        object.__setattr__(self, "lowest", lowest)

    def touched_cells(self, shape: Shape, pose: npt.ArrayLike) -> BoolArray:
        """Cells (nx, ny) that the upright shape's footprint may touch (half a diagonal added)."""
        touched = np.zeros(self.lowest.shape, dtype=np.bool_)
        window = self._around(shape, pose)
        touched[window] = self._touched(shape, pose, window)
        return touched

    def _around(self, shape: Shape, pose: npt.ArrayLike) -> tuple[slice, slice]:
        """The cells near the footprint; nothing outside is touched."""
        reach = shape.footprint_radius / self.resolution + _BORDER
        middle = (np.asarray(pose, dtype=np.float64)[:2] - self.origin) / self.resolution
        i, j = np.maximum(middle - reach, 0.0).astype(np.int64).tolist()
        i_end, j_end = np.maximum(middle + reach, 0.0).astype(np.int64).tolist()
        return slice(i, i_end), slice(j, j_end)

    def _touched(self, shape: Shape, pose: npt.ArrayLike, window: tuple[slice, slice]) -> BoolArray:
        """Which cells of a ``window`` the footprint may touch."""
        values = np.asarray(pose, dtype=np.float64)
        rows, columns = (
            np.arange(count)[part] + 0.5
            for count, part in zip(self.lowest.shape, window, strict=True)
        )
        x = self.origin[0] + rows * self.resolution - values[0]
        y = self.origin[1] + columns * self.resolution - values[1]
        reach = self.resolution * np.sqrt(0.5)
        if not isinstance(shape, Box):
            return x[:, None] ** 2 + y[None, :] ** 2 <= (shape.radius + reach) ** 2
        yaw = yaw_of(values)
        c, s = np.cos(yaw), np.sin(yaw)
        u = np.abs(c * x[:, None] + s * y[None, :]) - shape.size[0] / 2.0
        v = np.abs(-s * x[:, None] + c * y[None, :]) - shape.size[1] / 2.0
        return np.hypot(np.maximum(u, 0.0), np.maximum(v, 0.0)) <= reach

    def swept_under(self, top: float) -> BoolArray:
        """Cells (nx, ny) whose sweep comes below the height ``top`` (m, world)."""
        return self.lowest < top

    def overlap(self, shape: Shape, pose: npt.ArrayLike) -> float:
        """Area (m^2) of the standing shape's footprint that the sweep would hit."""
        top = float(np.asarray(pose)[2]) + shape.height / 2.0
        window = self._around(shape, pose)
        cells = self._touched(shape, pose, window) & (self.lowest[window] < top)
        return float(cells.sum()) * self.resolution**2

    def overlaps(self, shape: Shape, pose: npt.ArrayLike) -> bool:
        """Whether the standing shape is inside the region."""
        return self.overlap(shape, pose) > 0.0

    def united(self, other: SweptRegion) -> SweptRegion:
        """The space that either region sweeps; both must have the same cells."""
        return SweptRegion(
            self.origin, self.resolution, np.minimum(self.lowest, other.lowest), self.floor
        )
