"""How far the tool still has to go around obstacles: the 3-D heuristic of thesis 3.4.2."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numba import njit

from mamo_core.types.geometry import Array, BoolArray, Box, IntArray, Shape, matrix_from_pose

_UNREACHED = np.iinfo(np.int64).max
_CHAMFER = (10, 14, 17)
"""Cost of a step to a neighbour that shares a face, an edge, a corner: tenths of a cell."""


class DistanceField:
    """Lengths of shortest ways of a point among grown obstacles, from every cell of a box."""

    def __init__(
        self,
        lower: Array,
        upper: Array,
        resolution: float,
        solids: Iterable[tuple[Shape, Array]],
        growth: float,
    ) -> None:
        """``lower``, ``upper`` (3,) m, world; ``solids``: shapes with poses (7,), grown by m."""
        self._lower, self._resolution = np.array(lower), resolution
        shape = np.ceil((np.asarray(upper) - lower) / resolution).astype(np.int64) + 1
        self._blocked: BoolArray = np.zeros(tuple(shape), dtype=np.bool_)
        for solid, pose in solids:
            self._block(solid, pose, growth)
        self._costs: IntArray = np.full(tuple(shape), _UNREACHED)

    def spread_from(self, points: Array) -> None:
        """Measure from ``points`` (k, 3); cells around them are opened, as hands end in between."""
        cells = np.array([self._cell(point) for point in points])
        spread(self._blocked, cells, np.array(_CHAMFER), self._costs)

    def distance(self, point: Array) -> float:
        """Metres from a point (3,) to the nearest source; infinite where there is no way."""
        i, j, k = self._cell(point)
        cost = int(self._costs[i, j, k])
        return math.inf if cost == _UNREACHED else cost / _CHAMFER[0] * self._resolution

    def _cell(self, point: Array) -> tuple[int, int, int]:
        """The cell of a point, of the nearest one for points outside."""
        cell = np.rint((point - self._lower) / self._resolution).astype(np.int64)
        i, j, k = np.clip(cell, 0, np.array(self._blocked.shape) - 1).tolist()
        return i, j, k

    def _block(self, solid: Shape, pose: Array, growth: float) -> None:
        T = matrix_from_pose(pose)
        half = _half_extents(solid) + growth
        spread_out = np.abs(T[:3, :3]) @ half
        first = np.array(self._cell(T[:3, 3] - spread_out))
        last = np.array(self._cell(T[:3, 3] + spread_out)) + 1
        box = tuple(slice(a, b) for a, b in zip(first.tolist(), last.tolist(), strict=True))
        axes = [np.arange(a, b) for a, b in zip(first.tolist(), last.tolist(), strict=True)]
        centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1) * self._resolution
        local = np.abs((centres + self._lower - T[:3, 3]) @ T[:3, :3])
        if isinstance(solid, Box):
            inside = (local <= half).all(axis=-1)
        else:
            inside = (np.hypot(local[..., 0], local[..., 1]) <= half[0]) & (
                local[..., 2] <= half[2]
            )
        self._blocked[box] |= inside


def _half_extents(solid: Shape) -> Array:
    if isinstance(solid, Box):
        return solid.size / 2.0
    return np.array([solid.radius, solid.radius, solid.height / 2.0])


def warm_up() -> None:
    """Compile the kernel (or read it from numba's cache)."""
    DistanceField(np.zeros(3), np.full(3, 0.1), 0.1, [], 0.0).spread_from(np.zeros((1, 3)))


@njit(cache=True)
def spread(blocked: BoolArray, sources: IntArray, chamfer: IntArray, costs: IntArray) -> None:
    """Dijkstra with buckets (Dial, 1969) over 26 neighbours; fills ``costs`` of what is reached.

    From a source the way leads out even through blocked cells, but never back into them.
    """
    nx, ny, nz = costs.shape
    most = chamfer[2] + 1
    heads = np.full(most, -1, dtype=np.int64)
    # A cell may wait in several buckets; entries that are out of date are passed over.
    nexts = np.empty(27 * costs.size + len(sources), dtype=np.int32)
    cells = np.empty(27 * costs.size + len(sources), dtype=np.int32)
    count = 0
    flat = costs.reshape(-1)
    for s in range(len(sources)):
        cell = (sources[s, 0] * ny + sources[s, 1]) * nz + sources[s, 2]
        flat[cell] = 0
        cells[count], nexts[count] = cell, heads[0]
        heads[0] = count
        count += 1
    cost, idle = 0, 0
    while idle < most:
        entry = heads[cost % most]
        heads[cost % most] = -1
        idle = idle + 1 if entry < 0 else 0
        while entry >= 0:
            cell = cells[entry]
            entry = nexts[entry]
            if flat[cell] != cost:
                continue
            i, rest = divmod(cell, ny * nz)
            j, k = divmod(rest, nz)
            out = blocked[i, j, k]
            for di in range(-1, 2):
                for dj in range(-1, 2):
                    for dk in range(-1, 2):
                        a, b, c = i + di, j + dj, k + dk
                        kind = abs(di) + abs(dj) + abs(dk)
                        if kind == 0 or not (0 <= a < nx and 0 <= b < ny and 0 <= c < nz):
                            continue
                        if blocked[a, b, c] and not out:
                            continue
                        other = (a * ny + b) * nz + c
                        longer = cost + chamfer[kind - 1]
                        if longer < flat[other]:
                            flat[other] = longer
                            cells[count], nexts[count] = other, heads[longer % most]
                            heads[longer % most] = count
                            count += 1
        cost += 1
