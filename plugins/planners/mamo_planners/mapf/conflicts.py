"""Where the paths of a solution run into each other, and the box to split on (kernels).

A pair that starts too close is left alone until it has parted (never nearer than it began); from
then on the full margin counts.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mamo_planners.mapf.constraints import FOREVER
from mamo_planners.mapf.distance import BoolArray, Int64Array
from mamo_planners.mapf.kernel import kernel
from mamo_planners.mapf.tables import APART, CLOSEST, Int16Array, Int32Array, PairTables, overlap

TOO_CLOSE, MEET_AGAIN, PARTED = 0, 1, 2
"""Overlap; overlap of a pair that had parted; parting where the branch says together."""

FIRST, SECOND, WHEN, DEPTH, WHAT = range(5)
"""Columns of a conflict: agents i < j, time, depth in steps, kind."""


@kernel
def slack(
    low: Int16Array,
    high: Int16Array,
    first: Int32Array,
    table: int,
    i: int,
    j: int,
    dx: int,
    dy: int,
    sx: int,
    sy: int,
) -> int:
    """Steps that the offset may go along (sx, sy) before the pair no longer overlaps."""
    steps = 0
    while overlap(low, high, first, table, i, j, dx + (steps + 1) * sx, dy + (steps + 1) * sy):
        steps += 1
    return steps


@kernel
def _depth(
    low: Int16Array,
    high: Int16Array,
    first: Int32Array,
    table: int,
    i: int,
    j: int,
    dx: int,
    dy: int,
) -> int:
    """Steps to the nearest offset without overlap, along x or y."""
    least = FOREVER
    for sx, sy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        least = min(least, slack(low, high, first, table, i, j, dx, dy, sx, sy))
    return least


@kernel
def _pair_conflict(
    i: int,
    j: int,
    paths: Int32Array,
    lengths: Int64Array,
    low: Int16Array,
    high: Int16Array,
    first: Int32Array,
    touching: bool,
    together: int,
    found: Int64Array,
) -> bool:
    """The pair's deepest conflict into ``found`` (5,); ``together``: it may not part by then."""
    parted = not touching
    found[FIRST], found[SECOND], found[DEPTH] = i, j, -1
    for t in range(1, max(lengths[i], lengths[j])):
        a, b = min(t, lengths[i] - 1), min(t, lengths[j] - 1)
        dx = paths[i, a, 0] - paths[j, b, 0]
        dy = paths[i, a, 1] - paths[j, b, 1]
        kind, table = -1, CLOSEST
        if overlap(low, high, first, CLOSEST, i, j, dx, dy):
            kind = TOO_CLOSE
        elif touching and not overlap(low, high, first, APART, i, j, dx, dy):
            parted = True
            if t <= together:
                found[WHEN], found[DEPTH], found[WHAT] = t, 0, PARTED
                return True
        elif touching and parted:
            kind, table = MEET_AGAIN, APART
        if kind >= 0:
            depth = _depth(low, high, first, table, i, j, dx, dy)
            if depth > found[DEPTH]:
                found[WHEN], found[DEPTH], found[WHAT] = t, depth, kind
    return found[DEPTH] >= 0


def find_conflicts(
    paths: Int32Array,
    lengths: Int64Array,
    tables: PairTables,
    together: npt.NDArray[np.int32],
) -> Int64Array:
    """Conflicts (c, 5), at most one a pair, at its deepest time.

    ``paths`` (n, T, 2) in steps; ``lengths`` (n,); ``together`` (n, n): time until which a pair
    that starts too close is meant not to part, 0 where nothing is meant.
    """
    n = len(lengths)
    found = np.empty((n * (n - 1) // 2 + 1, 5), dtype=np.int64)
    return found[: _find(paths, lengths, *tables, together, found)]


@kernel
def _find(
    paths: Int32Array,
    lengths: Int64Array,
    low: Int16Array,
    high: Int16Array,
    first: Int32Array,
    touching: BoolArray,
    together: Int32Array,
    found: Int64Array,
) -> int:
    count = 0
    for i in range(lengths.shape[0]):
        for j in range(i + 1, lengths.shape[0]):
            if lengths[i] == 1 and lengths[j] == 1:
                continue
            count += _pair_conflict(
                i,
                j,
                paths,
                lengths,
                low,
                high,
                first,
                touching[i, j],
                together[i, j],
                found[count],
            )
    return count


@kernel
def split_box(
    tables: PairTables,
    table: int,
    i: int,
    j: int,
    xi: int,
    yi: int,
    xj: int,
    yj: int,
    share: float,
) -> tuple[int, int, int, int]:
    """A box around j's cell, anywhere in which j overlaps i at its cell.

    It takes ``share`` of the steps that j could move in each direction and still overlap, so
    that both sides of the split forbid about as much. Returns least x, y and largest x, y.
    """
    low, high, first, _ = tables
    dx, dy = xi - xj, yi - yj
    left = int(share * slack(low, high, first, table, i, j, dx, dy, 1, 0))
    right = int(share * slack(low, high, first, table, i, j, dx, dy, -1, 0))
    down = int(share * slack(low, high, first, table, i, j, dx, dy, 0, 1))
    up = int(share * slack(low, high, first, table, i, j, dx, dy, 0, -1))
    while left + right + down + up > 0:
        inside = (
            overlap(low, high, first, table, i, j, dx + left, dy + down)
            and overlap(low, high, first, table, i, j, dx + left, dy - up)
            and overlap(low, high, first, table, i, j, dx - right, dy + down)
            and overlap(low, high, first, table, i, j, dx - right, dy - up)
        )
        if inside:
            break
        left, right = max(left - 1, 0), max(right - 1, 0)
        down, up = max(down - 1, 0), max(up - 1, 0)
    return xj - left, yj - down, xj + right, yj + up
