"""Constraints on one agent, as rows (9,) int32, and their checks (kernels).

``RECT(box, t0, t1)``: not in the box. ``REGION(other, box, t0, t1)``: not where it overlaps
``other`` wherever in the box that is. ``NOTPARKED(box, t)``: not come to rest in the box by t.

A pair of them splits a conflict soundly: whenever the other agent is in the box and this one in
the region, they overlap, so every solution keeps one of the two (rectangle constraints for
large agents: Li et al., AAAI 2019, MC-CBS; the split on resting generalises target reasoning,
Li et al., AIJ 2021, to goal sets).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from mamo_planners.mapf.distance import BoolArray, Int64Array
from mamo_planners.mapf.kernel import kernel
from mamo_planners.mapf.tables import Int32Array, PairTables

RECT, REGION, NOTPARKED = 0, 1, 2
KIND, OTHER, TABLE, X0, Y0, X1, Y1, T0, T1 = range(9)
FOREVER = 1 << 30

NONE: npt.NDArray[np.int32] = np.zeros((0, 9), dtype=np.int32)
"""No constraints."""


def constraint(
    kind: int, other: int, table: int, box: tuple[int, int, int, int], t0: int, t1: int
) -> Int32Array:
    """One row; ``box``: least x, least y, largest x, largest y in lattice steps."""
    return np.array([[kind, other, table, *box, t0, t1]], dtype=np.int32)


class Forbidden(NamedTuple):
    """What rows of constraints forbid one agent, per cell of its lattice, for one search.

    ``at`` (layers, cells): forbidden at that time where it holds the search's stamp. ``since``
    (cells,): forbidden from that time on. ``until`` (cells,): no coming to rest up to that time.
    """

    at: Int32Array
    since: Int32Array
    until: Int32Array


@kernel
def mark_forbidden(
    rows: Int32Array,
    agent: int,
    first: Int64Array,
    free: BoolArray,
    tables: PairTables,
    stamp: int,
    forbidden: Forbidden,
) -> None:
    """Writes down what the rows forbid on the lattice of ``free`` (nx, ny) from ``first``."""
    nx, ny = free.shape
    forbidden.since[: nx * ny] = FOREVER
    forbidden.until[: nx * ny] = -1
    for k in range(rows.shape[0]):
        row = rows[k]
        x_low, x_high, y_low, y_high = row[X0], row[X1], row[Y0], row[Y1]
        if row[KIND] == REGION:
            x_low = row[X1] + tables.first[row[TABLE], agent, row[OTHER]]
            x_high = row[X0] + tables.first[row[TABLE], agent, row[OTHER]] + tables.low.shape[3]
            y_low, y_high = -FOREVER, FOREVER
        for x in range(max(x_low - first[0], 0), min(x_high - first[0] + 1, nx)):
            low, high = y_low, y_high
            if row[KIND] == REGION:
                low, high = _region_column(row, agent, x + first[0], tables)
            for y in range(max(low - first[1], 0), min(high - first[1] + 1, ny)):
                _forbid(row, x * ny + y, stamp, forbidden)


@kernel
def _forbid(row: Int32Array, cell: int, stamp: int, forbidden: Forbidden) -> None:
    if row[KIND] == NOTPARKED:
        forbidden.until[cell] = max(forbidden.until[cell], row[T0])
        return
    forbidden.until[cell] = max(forbidden.until[cell], row[T1])
    if row[T1] == FOREVER:
        forbidden.since[cell] = min(forbidden.since[cell], row[T0])
        return
    for t in range(row[T0], row[T1] + 1):
        forbidden.at[t, cell] = stamp


@kernel
def _region_column(row: Int32Array, agent: int, x: int, tables: PairTables) -> tuple[int, int]:
    """Least and largest y at which the agent overlaps the other in all of the box.

    Overlapping offsets are convex, so the box's corners speak for it.
    """
    table, other = row[TABLE], row[OTHER]
    low, high = -FOREVER, FOREVER
    for side in range(2):
        k = x - (row[X0] if side == 0 else row[X1]) - tables.first[table, agent, other]
        if k < 0 or k >= tables.low.shape[3]:
            return 1, 0
        low = max(low, tables.low[table, agent, other, k] + row[Y1])
        high = min(high, tables.high[table, agent, other, k] + row[Y0])
    return low, high


def last_time(rows: Int32Array) -> int:
    """Time from which the rows say the same for ever."""
    if len(rows) == 0:
        return 0
    ends = np.where(
        (rows[:, KIND] == NOTPARKED) | (rows[:, T1] == FOREVER), rows[:, T0], rows[:, T1]
    )
    return int(ends.max()) + 1
