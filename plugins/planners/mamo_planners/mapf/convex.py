"""Exact plane geometry of rounded convex polygons (kernels).

Two footprints overlap at an offset d between them exactly where d lies in the difference of the
two (a Minkowski sum, convex), so pairs need one polygon and a radius. A line x = const cuts it in
one interval, which has a closed form.
"""

from __future__ import annotations

import numpy as np

from mamo_core.types.geometry import Array
from mamo_planners.mapf.kernel import kernel


@kernel
def _turns_left(chain: Array, size: int, x: float, y: float) -> bool:
    """Whether (x, y) lies left of the last edge of the first ``size`` points of the chain."""
    ax, ay = chain[size - 2, 0], chain[size - 2, 1]
    bx, by = chain[size - 1, 0], chain[size - 1, 1]
    return (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 1e-15


@kernel
def hull(points: Array, count: int) -> Array:
    """Convex hull (k, 2) of the first ``count`` points (n, 2), counter-clockwise."""
    order = np.empty((count, 2))
    for i in range(count):  # insertion sort: there are few points
        k = i
        x, y = points[i, 0], points[i, 1]
        while k > 0 and (order[k - 1, 0] > x or (order[k - 1, 0] == x and order[k - 1, 1] > y)):
            order[k, 0], order[k, 1] = order[k - 1, 0], order[k - 1, 1]
            k -= 1
        order[k, 0], order[k, 1] = x, y
    chain = np.empty((2 * count + 2, 2))
    size = 0
    for i in range(count):
        while size >= 2 and not _turns_left(chain, size, order[i, 0], order[i, 1]):
            size -= 1
        chain[size, 0], chain[size, 1] = order[i, 0], order[i, 1]
        size += 1
    lower = size + 1
    for i in range(count - 2, -1, -1):
        while size >= lower and not _turns_left(chain, size, order[i, 0], order[i, 1]):
            size -= 1
        chain[size, 0], chain[size, 1] = order[i, 0], order[i, 1]
        size += 1
    if size > 1:
        size -= 1  # the first point closed the loop
    return chain[:size]


@kernel
def difference(first: Array, n_first: int, second: Array, n_second: int) -> Array:
    """Offsets (k, 2) of ``first`` from ``second`` at which their hulls touch or overlap."""
    points = np.empty((n_first * n_second, 2))
    for a in range(n_first):
        for b in range(n_second):
            points[a * n_second + b, 0] = second[b, 0] - first[a, 0]
            points[a * n_second + b, 1] = second[b, 1] - first[a, 1]
    return hull(points, n_first * n_second)


@kernel
def signed_distance(x: float, y: float, polygon: Array) -> float:
    """Distance (m) from (x, y) to a convex polygon (k, 2); negative inside: minus the depth."""
    n = polygon.shape[0]
    nearest = np.inf
    deepest = -np.inf
    for k in range(n):
        ax, ay = polygon[k, 0], polygon[k, 1]
        ex, ey = polygon[(k + 1) % n, 0] - ax, polygon[(k + 1) % n, 1] - ay
        length = np.hypot(ex, ey)
        px, py = x - ax, y - ay
        if length > 0.0:
            along = min(max((px * ex + py * ey) / length, 0.0), length) / length
            nearest = min(nearest, np.hypot(px - along * ex, py - along * ey))
            deepest = max(deepest, (px * ey - py * ex) / length)
        else:
            nearest = min(nearest, np.hypot(px, py))
    return deepest if n >= 3 and deepest <= 0.0 else nearest


@kernel
def row_intervals(
    polygon: Array, reach: float, x0: float, step: float, low: Array, high: Array
) -> None:
    """Least and largest y (m) within ``reach`` of the polygon (k, 2) on the lines x0 + i step.

    Written into ``low`` and ``high`` (rows,); low > high where the line misses. A negative
    ``reach`` shrinks the polygon. ``step`` is above zero.
    """
    if reach < 0.0:
        _inset_rows(polygon, reach, x0, step, low, high)
        return
    n, rows = polygon.shape[0], low.shape[0]
    for i in range(rows):
        low[i], high[i] = np.inf, -np.inf
    for k in range(n):
        ax, ay = polygon[k, 0], polygon[k, 1]
        begin = max(int(np.ceil((ax - reach - x0) / step)), 0)
        end = min(int(np.floor((ax + reach - x0) / step)) + 1, rows)
        for i in range(begin, end):
            dx = x0 + i * step - ax
            rise = np.sqrt(max(reach * reach - dx * dx, 0.0))
            low[i], high[i] = min(low[i], ay - rise), max(high[i], ay + rise)
        ex, ey = polygon[(k + 1) % n, 0] - ax, polygon[(k + 1) % n, 1] - ay
        if ex == 0.0:
            continue  # the ends of a vertical edge are covered by its vertices' rows
        length = np.sqrt(ex * ex + ey * ey)
        left, base, slope = ax + reach * ey / length, ay - reach * ex / length, ey / ex
        right = left + ex
        begin = max(int(np.ceil((min(left, right) - x0) / step)), 0)
        end = min(int(np.floor((max(left, right) - x0) / step)) + 1, rows)
        for i in range(begin, end):
            y = base + (x0 + i * step - left) * slope
            low[i], high[i] = min(low[i], y), max(high[i], y)


@kernel
def _inset_rows(
    polygon: Array, reach: float, x0: float, step: float, low: Array, high: Array
) -> None:
    n = polygon.shape[0]  # a polygon without area has no inside
    for i in range(low.shape[0]):
        low[i], high[i] = (-np.inf if n >= 3 else np.inf), np.inf
    for k in range(n):
        ax, ay = polygon[k, 0], polygon[k, 1]
        ex, ey = polygon[(k + 1) % n, 0] - ax, polygon[(k + 1) % n, 1] - ay
        length = np.sqrt(ex * ex + ey * ey)
        if n < 3 or length == 0.0:
            continue
        nx, ny = ey / length, -ex / length
        most = nx * ax + ny * ay + reach
        for i in range(low.shape[0]):
            room = most - nx * (x0 + i * step)
            if ny > 1e-12:
                high[i] = min(high[i], room / ny)
            elif ny < -1e-12:
                low[i] = max(low[i], room / ny)
            elif room < 0.0:
                low[i] = np.inf
