"""Which relative offsets of two agents overlap: one lookup instead of a collision check.

Orientations never change, so a pair's overlap depends on the offset of the two lattice positions
alone. The overlapping offsets form a convex set, stored as one interval a lattice row.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from mamo_core.types.geometry import Array, BoolArray
from mamo_planners.mapf.convex import difference, row_intervals, signed_distance
from mamo_planners.mapf.footprint import FootprintArrays
from mamo_planners.mapf.kernel import kernel

Int16Array = npt.NDArray[np.int16]
Int32Array = npt.NDArray[np.int32]

TOUCH = 1e-9
"""Metres by which two things may come too close before it counts (rounding, not physics)."""

CLOSEST = 0
"""Table: offsets nearer than allowed at any time (never nearer than the pair starts)."""
APART = 1
"""Table: offsets nearer than the full margin (what a pair that has parted must keep)."""


class PairTables(NamedTuple):
    """Overlap intervals of all ordered pairs (i, j) over the offset k = k_i - k_j, in steps.

    Row k_x - ``first[table, i, j]`` of ``low``/``high`` (2, n, n, w) holds the overlapping k_y,
    both ends included; the first axis is ``CLOSEST`` or ``APART``. ``touching`` (n, n): pairs
    nearer than the margin at the start.
    """

    low: Int16Array
    high: Int16Array
    first: Int32Array
    touching: BoolArray


def build_pair_tables(shapes: FootprintArrays, resolution: float, margin: float) -> PairTables:
    """Tables of every pair of ``shapes`` on a lattice of ``resolution`` m, ``margin`` m apart."""
    used = np.arange(shapes.points.shape[1]) < shapes.sizes[:, None]
    reach = np.where(used, np.hypot(shapes.points[..., 0], shapes.points[..., 1]), 0.0).max(axis=1)
    reach = reach + shapes.radius
    width = int(np.ceil(2.0 * (2.0 * reach.max() + margin) / resolution)) + 4
    n = len(shapes.sizes)
    tables = PairTables(
        np.ones((2, n, n, width), dtype=np.int16),
        np.zeros((2, n, n, width), dtype=np.int16),
        np.zeros((2, n, n), dtype=np.int32),
        np.zeros((n, n), dtype=np.bool_),
    )
    _fill_tables(*shapes, resolution, margin, *tables, np.empty((2, width)))
    return tables


@kernel
def _fill_tables(
    position: Array,
    points: Array,
    sizes: npt.NDArray[np.int64],
    radius: Array,
    bottom: Array,
    top: Array,
    step: float,
    margin: float,
    low: Int16Array,
    high: Int16Array,
    first: Int32Array,
    touching: BoolArray,
    rows: Array,
) -> None:
    """Fills empty tables; ``rows`` (2, w): room for one table's intervals in metres."""
    n, width = position.shape[0], low.shape[3]
    for i in range(n):
        for j in range(i + 1, n):
            if min(top[i], top[j]) - max(bottom[i], bottom[j]) <= TOUCH:
                continue
            polygon = difference(points[i], sizes[i], points[j], sizes[j])
            x = position[i, 0] - position[j, 0]
            y = position[i, 1] - position[j, 1]
            both = radius[i] + radius[j]
            gap = signed_distance(x, y, polygon) - both
            touching[i, j] = touching[j, i] = gap < margin - TOUCH
            left = np.inf
            for k in range(polygon.shape[0]):
                left = min(left, polygon[k, 0])
            row = int(np.floor((left - both - margin - x) / step))
            for table in range(2):
                if table == CLOSEST or touching[i, j]:
                    keep = min(margin, gap) if table == CLOSEST else margin
                    reach = both + keep - TOUCH
                    row_intervals(polygon, reach, x + row * step, step, rows[0], rows[1])
                first[table, i, j], first[table, j, i] = row, -(row + width - 1)
                for k in range(width):
                    if rows[0, k] > rows[1, k]:
                        continue
                    least = int(np.ceil((rows[0, k] - y) / step))
                    most = int(np.floor((rows[1, k] - y) / step))
                    low[table, i, j, k], high[table, i, j, k] = least, most
                    low[table, j, i, width - 1 - k] = -most
                    high[table, j, i, width - 1 - k] = -least


@kernel
def overlap(
    low: Int16Array,
    high: Int16Array,
    first: Int32Array,
    table: int,
    i: int,
    j: int,
    dx: int,
    dy: int,
) -> bool:
    """Whether agents i and j overlap at the lattice offset (dx, dy) of i from j, in steps."""
    k = dx - first[table, i, j]
    if k < 0 or k >= low.shape[3]:
        return False
    return low[table, i, j, k] <= dy and dy <= high[table, i, j, k]
