"""Which relative offsets of two agents overlap: one lookup instead of a collision check.

Orientations never change, so a pair's overlap depends on the offset of the two lattice positions
alone. The overlapping offsets form a convex set, stored as one interval a lattice row.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from mamo_planners.mapf.kernel import kernel

from mamo_core.types.geometry import Array, BoolArray
from mamo_planners.mapf.convex import difference, row_intervals, signed_distance
from mamo_planners.mapf.footprint import FootprintArrays

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
    used = np.arange(shapes.points.shape[1]) < shapes.count[:, None]
    reach = np.where(used, np.hypot(shapes.points[..., 0], shapes.points[..., 1]), 0.0).max(axis=1)
    reach = reach + shapes.radius
    width = int(np.ceil(2.0 * (2.0 * reach.max() + margin) / resolution)) + 4
    return _pair_tables(shapes, resolution, margin, width)


@kernel
def _fill_rows(
    low: Int16Array,
    high: Int16Array,
    polygon: Array,
    reach: float,
    x0: float,
    y0: float,
    step: float,
) -> int:
    """Intervals of the offsets x0 + k step; returns the k_x of row 0."""
    left = np.inf
    for k in range(polygon.shape[0]):
        left = min(left, polygon[k, 0])
    first = int(np.floor((left - max(reach, 0.0) - x0) / step))
    rows = low.shape[0]
    a, b = np.empty(rows), np.empty(rows)
    row_intervals(polygon, reach, x0 + first * step, step, a, b)
    for k in range(rows):
        if a[k] <= b[k]:
            low[k] = int(np.ceil((a[k] - y0) / step))
            high[k] = int(np.floor((b[k] - y0) / step))
    return first


@kernel
def _pair_tables(shapes: FootprintArrays, step: float, margin: float, width: int) -> PairTables:
    position, points, count, radius, bottom, top = shapes
    n = position.shape[0]
    low = np.ones((2, n, n, width), np.int16)
    high = np.zeros((2, n, n, width), np.int16)
    first = np.zeros((2, n, n), np.int32)
    touching = np.zeros((n, n), np.bool_)
    for i in range(n):
        for j in range(i + 1, n):
            if min(top[i], top[j]) - max(bottom[i], bottom[j]) <= TOUCH:
                continue
            polygon = difference(points[i], count[i], points[j], count[j])
            x, y = position[i] - position[j]
            both = radius[i] + radius[j]
            gap = signed_distance(x, y, polygon) - both
            touching[i, j] = touching[j, i] = gap < margin - TOUCH
            for table in range(2):
                if table == CLOSEST or touching[i, j]:
                    keep = min(margin, gap) if table == CLOSEST else margin
                    a, b = low[table, i, j], high[table, i, j]
                    row = _fill_rows(a, b, polygon, both + keep - TOUCH, x, y, step)
                    first[table, i, j], first[table, j, i] = row, -(row + width - 1)
                    for k in range(width):
                        low[table, j, i, width - 1 - k] = -b[k]
                        high[table, j, i, width - 1 - k] = -a[k]
                else:
                    for p, q in ((i, j), (j, i)):
                        low[APART, p, q] = low[CLOSEST, p, q]
                        high[APART, p, q] = high[CLOSEST, p, q]
                        first[APART, p, q] = first[CLOSEST, p, q]
    return PairTables(low, high, first, touching)


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
