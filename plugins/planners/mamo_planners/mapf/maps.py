"""What one agent may do on its lattice, whatever the others do (kernels).

Every map is an array (nx, ny) over the lattice steps ``first + [0, n)`` from the agent's start.
"""

from __future__ import annotations

import numpy as np

from mamo_core.types.geometry import Array, BoolArray
from mamo_planners.mapf.convex import difference, hull, row_intervals, signed_distance
from mamo_planners.mapf.distance import FAR, Int64Array
from mamo_planners.mapf.footprint import FootprintArrays
from mamo_planners.mapf.kernel import kernel
from mamo_planners.mapf.tables import TOUCH, Int32Array


@kernel
def free_cells(
    agent: int,
    shapes: FootprintArrays,
    obstacles: FootprintArrays,
    margin: float,
    first: Int64Array,
    size: Int64Array,
    step: float,
) -> BoolArray:
    """Cells (nx, ny) at which one of ``shapes`` is at least ``margin`` m from every obstacle.

    An obstacle that is nearer than that at the start is kept at the start's distance instead:
    the agent may leave it, and may never come closer than it was.
    """
    free = np.ones((size[0], size[1]), np.bool_)
    a, b = np.empty(size[0]), np.empty(size[0])
    points, used = shapes.points[agent], shapes.sizes[agent]
    bottom, top = shapes.bottom[agent], shapes.top[agent]
    for o in range(obstacles.position.shape[0]):
        if min(top, obstacles.top[o]) - max(bottom, obstacles.bottom[o]) <= TOUCH:
            continue
        polygon = difference(points, used, obstacles.points[o], obstacles.sizes[o])
        x0 = shapes.position[agent, 0] - obstacles.position[o, 0]
        y0 = shapes.position[agent, 1] - obstacles.position[o, 1]
        both = shapes.radius[agent] + obstacles.radius[o]
        keep = min(margin, signed_distance(x0, y0, polygon) - both)
        row_intervals(polygon, both + keep - TOUCH, x0 + first[0] * step, step, a, b)
        for i in range(size[0]):
            if a[i] > b[i]:
                continue
            low = max(int(np.ceil((a[i] - y0) / step)) - first[1], 0)
            high = min(int(np.floor((b[i] - y0) / step)) - first[1], size[1] - 1)
            for j in range(low, high + 1):
                free[i, j] = False
    return free


@kernel
def starts_inside(
    shapes: FootprintArrays, origin: Array, resolution: float, lowest: Array
) -> BoolArray:
    """Which agents (n,) are inside the region where they start (as ``SweptRegion.overlaps``)."""
    position, points, sizes, radius, _, top = shapes
    n = position.shape[0]
    inside = np.zeros(n, np.bool_)
    half_diagonal = resolution * np.sqrt(0.5)
    for i in range(n):
        polygon = hull(points[i], sizes[i])
        reach = radius[i] + half_diagonal + TOUCH
        far = reach
        for k in range(polygon.shape[0]):
            far = max(far, reach + np.hypot(polygon[k, 0], polygon[k, 1]))
        x, y = position[i, 0] - origin[0], position[i, 1] - origin[1]
        left = max(int((x - far) / resolution), 0)
        right = min(int((x + far) / resolution) + 1, lowest.shape[0])
        low = max(int((y - far) / resolution), 0)
        high = min(int((y + far) / resolution) + 1, lowest.shape[1])
        for a in range(left, right):
            for b in range(low, high):
                if inside[i] or lowest[a, b] >= top[i]:
                    continue
                dx, dy = (a + 0.5) * resolution - x, (b + 0.5) * resolution - y
                inside[i] = signed_distance(dx, dy, polygon) <= reach
    return inside


@kernel
def _mark(
    change: Int32Array,
    row: int,
    low: float,
    high: float,
    y_first: float,
    y_last: float,
    first: int,
    step: float,
) -> None:
    """+1 and -1 around the cells whose y is between y_first - high and y_last - low."""
    last = change.shape[1] - 2
    j_low = max(int(np.ceil((y_first - high) / step)) - first, 0)
    j_high = min(int(np.floor((y_last - low) / step)) - first, last)
    if j_low <= j_high:
        change[row, j_low] += 1
        change[row, j_high + 1] -= 1


@kernel
def cells_inside(
    position: Array,
    points: Array,
    radius: float,
    top: float,
    origin: Array,
    resolution: float,
    lowest: Array,
    first: Int64Array,
    size: Int64Array,
    step: float,
) -> BoolArray:
    """Cells (nx, ny) at which the footprint would be inside the region.

    A run of swept cells in one region row covers, in one lattice row, one interval (or a few
    where the footprint is narrower than a region cell): +1 and -1 at the ends, summed up at last.
    """
    change = np.zeros((size[0], size[1] + 1), np.int32)
    polygon = hull(points, points.shape[0])  # symmetric about the pose, as boxes and cylinders
    reach = radius + resolution * np.sqrt(0.5) + TOUCH
    wide = reach
    for k in range(polygon.shape[0]):
        wide = max(wide, abs(polygon[k, 0]) + reach)
    a, b = np.empty(size[0]), np.empty(size[0])
    for row in range(lowest.shape[0]):
        x = origin[0] + (row + 0.5) * resolution - position[0]
        i_low = max(int(np.ceil((x - wide) / step)) - first[0], 0)
        i_high = min(int(np.floor((x + wide) / step)) - first[0], size[0] - 1)
        begin = 0
        known = i_high < i_low
        while begin < lowest.shape[1]:
            if lowest[row, begin] >= top:
                begin += 1
                continue
            end = begin
            while end + 1 < lowest.shape[1] and lowest[row, end + 1] < top:
                end += 1
            if not known:
                known = True
                left = (first[0] + i_low) * step - x
                rows = i_high + 1 - i_low
                row_intervals(polygon, reach, left, step, a[:rows], b[:rows])
            y = origin[1] + (begin + 0.5) * resolution - position[1]
            y_last = y + (end - begin) * resolution
            for i in range(i_low, i_high + 1):
                low, high = -b[i - i_low], -a[i - i_low]
                if low > high:
                    continue
                if high - low >= resolution:
                    _mark(change, i, low, high, y, y_last, first[1], step)
                else:
                    for k in range(end - begin + 1):
                        single = y + k * resolution
                        _mark(change, i, low, high, single, single, first[1], step)
            begin = end + 1
    return _summed(change)


@kernel
def _summed(change: Int32Array) -> BoolArray:
    inside = np.zeros((change.shape[0], change.shape[1] - 1), np.bool_)
    for i in range(inside.shape[0]):
        total = 0
        for j in range(inside.shape[1]):
            total += change[i, j]
            inside[i, j] = total > 0
    return inside


@kernel
def add_penalty(
    goal: Int64Array,
    dx: float,
    dy: float,
    radius: float,
    units: int,
    most: int,
    first: Int64Array,
    step: float,
) -> None:
    """Adds ``units`` to the goals (nx, ny) within ``radius`` m of (dx, dy) from the start.

    ``FAR`` forbids them; sums stop at ``most``.
    """
    nx, ny = goal.shape
    for i in range(nx):
        x = (first[0] + i) * step - dx
        if abs(x) > radius + TOUCH:
            continue
        for j in range(ny):
            y = (first[1] + j) * step - dy
            if goal[i, j] < FAR and np.hypot(x, y) <= radius + TOUCH:
                goal[i, j] = FAR if units >= FAR else min(goal[i, j] + units, most)
