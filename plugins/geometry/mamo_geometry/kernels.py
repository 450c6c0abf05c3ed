"""Compiled forward kinematics and sphere-against-primitive collision checks."""

from __future__ import annotations

import numpy as np
from numba import njit

from mamo_core.robots.distance_field import CELL, CURVATURE, HALF_DIAGONAL, PAD, STEP
from mamo_core.types.geometry import Array, BoolArray, IntArray
from mamo_geometry.arrays import ChainArrays, FieldArrays, SphereArrays, WorldArrays

# Small functions are inlined by force: a call would copy the descriptors of all arrays.

FAST = {"nnan", "ninf", "nsz"}
"""What may be left out without other digits: with more, they depend on what was inlined where."""

EDGE_STEP = 0.02
"""An edge is checked every so many metres that its furthest moving point may travel."""


@njit(cache=True, fastmath=FAST, error_model="numpy", forceinline=True)
def sine_cosine(x: float) -> tuple[float, float]:
    """Sine and cosine of an angle of a few turns, to 1e-15, faster than two calls of the library.

    Reduction to an eighth of a turn, then the polynomials of fdlibm's kernels.
    """
    k = np.rint(x * 0.6366197723675814)
    r = (x - k * 1.57079632673412561417e00) - k * 6.07710050650619224932e-11
    z = r * r
    s = 2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.5896909952115501e-10)
    s = 8.33333333332248946124e-03 + z * (-1.98412698298579493134e-04 + z * s)
    s = r + r * z * (-1.66666666666666324348e-01 + z * s)
    c = -2.75573143513906633035e-07 + z * (2.0875723212981748e-09 - z * 1.1359647557788195e-11)
    c = -1.38888888888741095749e-03 + z * (2.48015872894767294178e-05 + z * c)
    c = 1.0 - 0.5 * z + z * z * (4.16666666666666019037e-02 + z * c)
    quarter = int(k) & 3
    if quarter & 1:
        s, c = c, s
    if quarter & 2:
        s = -s
    if (quarter + 1) & 2:
        c = -c
    return s, c


@njit(cache=True, fastmath=FAST, error_model="numpy", forceinline=True)
def link_frames(chain: ChainArrays, q: Array, R: Array, p: Array) -> None:
    """World rotations ``R`` (dof, 3, 3) and origins ``p`` (dof, 3) of all links at ``q``."""
    for i in range(q.shape[0]):
        s, c = sine_cosine(q[i])
        for col in range(3):
            l0 = chain.A[i, 0, col] + s * chain.B[i, 0, col] + c * chain.C[i, 0, col]
            l1 = chain.A[i, 1, col] + s * chain.B[i, 1, col] + c * chain.C[i, 1, col]
            l2 = chain.A[i, 2, col] + s * chain.B[i, 2, col] + c * chain.C[i, 2, col]
            if i == 0:
                R[0, 0, col], R[0, 1, col], R[0, 2, col] = l0, l1, l2
            else:
                for row in range(3):
                    R[i, row, col] = (
                        R[i - 1, row, 0] * l0 + R[i - 1, row, 1] * l1 + R[i - 1, row, 2] * l2
                    )
        t0 = chain.t[i, 0] + chain.slide[i, 0] * q[i]
        t1 = chain.t[i, 1] + chain.slide[i, 1] * q[i]
        t2 = chain.t[i, 2] + chain.slide[i, 2] * q[i]
        if i == 0:
            p[0, 0], p[0, 1], p[0, 2] = t0, t1, t2
        else:
            for row in range(3):
                p[i, row] = (
                    p[i - 1, row]
                    + R[i - 1, row, 0] * t0
                    + R[i - 1, row, 1] * t1
                    + R[i - 1, row, 2] * t2
                )


@njit(cache=True, fastmath=FAST, error_model="numpy", forceinline=True)
def _place(R: Array, p: Array, i: int, s: Array, k: int) -> tuple[float, float, float]:
    """Sphere ``k`` of ``s``, given in link ``i``, in the world."""
    x = p[i, 0] + R[i, 0, 0] * s[k, 0] + R[i, 0, 1] * s[k, 1] + R[i, 0, 2] * s[k, 2]
    y = p[i, 1] + R[i, 1, 0] * s[k, 0] + R[i, 1, 1] * s[k, 1] + R[i, 1, 2] * s[k, 2]
    z = p[i, 2] + R[i, 2, 0] * s[k, 0] + R[i, 2, 1] * s[k, 1] + R[i, 2, 2] * s[k, 2]
    return x, y, z


@njit(cache=True, fastmath=FAST, error_model="numpy", forceinline=True)
def _near(w: WorldArrays, k: int, x: float, y: float, z: float, r: float) -> bool:
    """Whether a ball reaches primitive ``k``."""
    if (
        x + r < w.low[k, 0]
        or x - r > w.high[k, 0]
        or y + r < w.low[k, 1]
        or y - r > w.high[k, 1]
        or z + r < w.low[k, 2]
        or z - r > w.high[k, 2]
    ):
        return False
    dx, dy, dz = x - w.centre[k, 0], y - w.centre[k, 1], z - w.centre[k, 2]
    lx = w.rotation[k, 0, 0] * dx + w.rotation[k, 1, 0] * dy + w.rotation[k, 2, 0] * dz
    ly = w.rotation[k, 0, 1] * dx + w.rotation[k, 1, 1] * dy + w.rotation[k, 2, 1] * dz
    lz = w.rotation[k, 0, 2] * dx + w.rotation[k, 1, 2] * dy + w.rotation[k, 2, 2] * dz
    over_z = max(abs(lz) - w.half[k, 2], 0.0)
    if over_z > r:
        return False
    if w.round[k] == 1:
        side = max(np.sqrt(lx * lx + ly * ly) - w.half[k, 0], 0.0)
        return side * side + over_z * over_z < r * r
    over_x = max(abs(lx) - w.half[k, 0], 0.0)
    over_y = max(abs(ly) - w.half[k, 1], 0.0)
    return over_x * over_x + over_y * over_y + over_z * over_z < r * r


@njit(cache=True, fastmath=FAST, error_model="numpy", forceinline=True)
def _shortlist(w: WorldArrays, x: float, y: float, z: float, r: float, near: IntArray) -> int:
    """Primitives that a ball reaches, into ``near``; returns their number."""
    count = 0
    if (
        x + r < w.lower[0]
        or x - r > w.upper[0]
        or y + r < w.lower[1]
        or y - r > w.upper[1]
        or z + r < w.lower[2]
        or z - r > w.upper[2]
    ):
        return count
    for k in range(w.centre.shape[0]):
        if _near(w, k, x, y, z, r):
            near[count] = k
            count += 1
    return count


@njit(cache=True, fastmath=FAST, error_model="numpy", forceinline=True)
def _cluster_hits(
    s: SphereArrays, w: WorldArrays, R: Array, p: Array, i: int, c: int, near: IntArray, count: int
) -> bool:
    """Whether a sphere of cluster ``c`` touches one of the first ``count`` of ``near``.

    The second half of ``near`` is scratch space for those that the cluster itself may touch.
    """
    x, y, z = _place(R, p, i, s.clusters, c)
    r = s.clusters[c, 3] + w.margin
    half = near.shape[0] // 2
    close = half
    for n in range(count):
        if _near(w, near[n], x, y, z, r):
            near[close] = near[n]
            close += 1
    if close == half:
        return False
    for m in range(s.cluster_start[c], s.cluster_start[c + 1]):
        x, y, z = _place(R, p, i, s.spheres, m)
        r = s.spheres[m, 3] + w.margin
        for n in range(half, close):
            if _near(w, near[n], x, y, z, r):
                return True
    return False


@njit(cache=True, fastmath=FAST, error_model="numpy", forceinline=True)
def _reaches(f: FieldArrays, k: int, x: float, y: float, z: float, r: float) -> bool:
    """Whether a ball, given in the frame of field ``k``, may reach its surface."""
    if (
        x + r < f.low[k, 0]
        or x - r > f.high[k, 0]
        or y + r < f.low[k, 1]
        or y - r > f.high[k, 1]
        or z + r < f.low[k, 2]
        or z - r > f.high[k, 2]
    ):
        return False
    u = (x - f.origin[k, 0]) * (1.0 / CELL)
    v = (y - f.origin[k, 1]) * (1.0 / CELL)
    w = (z - f.origin[k, 2]) * (1.0 / CELL)
    if (
        u < 0.0
        or v < 0.0
        or w < 0.0
        or u >= f.counts[k, 0]
        or v >= f.counts[k, 1]
        or w >= f.counts[k, 2]
    ):
        return r > PAD
    # Without a sign: Python's negative indices would cost as much as all the rest.
    at = np.uintp(u) * f.strides[k, 0] + np.uintp(v) * f.strides[k, 1] + np.uintp(w)
    return f.cells[f.start[k] + at] * STEP - HALF_DIAGONAL < r


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _apart(f: FieldArrays, k: int, x: float, y: float, z: float, r: float) -> bool:
    """Whether a ball that ``_reaches`` field ``k`` is away from its surface all the same.

    By what lies between the centres of cells around it: dearer and finer.
    """
    u = (x - f.origin[k, 0]) * (1.0 / CELL) - 0.5
    v = (y - f.origin[k, 1]) * (1.0 / CELL) - 0.5
    w = (z - f.origin[k, 2]) * (1.0 / CELL) - 0.5
    if (
        u < 0.0
        or v < 0.0
        or w < 0.0
        or u >= f.counts[k, 0] - 1.0
        or v >= f.counts[k, 1] - 1.0
        or w >= f.counts[k, 2] - 1.0
    ):
        return False
    i, j, m = np.uintp(u), np.uintp(v), np.uintp(w)
    u, v, w = u - i, v - j, w - m
    s0, s1, one = f.strides[k, 0], f.strides[k, 1], np.uintp(1)
    a = f.start[k] + i * s0 + j * s1 + m
    b, c, d = a + s1, a + s0, a + s0 + s1
    a0, a1, b0, b1 = f.cells[a], f.cells[a + one], f.cells[b], f.cells[b + one]
    c0, c1, d0, d1 = f.cells[c], f.cells[c + one], f.cells[d], f.cells[d + one]
    lowest = min(min(min(a0, a1), min(b0, b1)), min(min(c0, c1), min(d0, d1)))
    nearest = lowest * STEP - HALF_DIAGONAL
    if nearest <= 0.0:
        return False
    ab = (1.0 - v) * ((1.0 - w) * a0 + w * a1) + v * ((1.0 - w) * b0 + w * b1)
    cd = (1.0 - v) * ((1.0 - w) * c0 + w * c1) + v * ((1.0 - w) * d0 + w * d1)
    distance = ((1.0 - u) * ab + u * cd) * STEP
    return (distance - r) * nearest >= CURVATURE


@njit(cache=True, fastmath=FAST, error_model="numpy", forceinline=True)
def _blocked(f: FieldArrays, q: Array) -> bool:
    """Whether neighbours but one may touch."""
    for n in range(f.tables.shape[0]):
        u = (q[f.tables[n, 0]] - f.table_low[n, 0]) * f.table_scale[n, 0]
        v = (q[f.tables[n, 1]] - f.table_low[n, 1]) * f.table_scale[n, 1]
        row = np.uintp(min(max(u, 0.0), f.table_last[n, 0]))
        column = np.uintp(min(max(v, 0.0), f.table_last[n, 1]))
        if f.blocked[f.tables[n, 2] + row * f.tables[n, 3] + column]:
            return True
    return False


@njit(cache=True, fastmath=FAST, error_model="numpy", forceinline=True)
def _meets_itself(f: FieldArrays, s: SphereArrays, q: Array, R: Array, p: Array) -> bool:
    """Whether spheres of the arm, or of what it holds, reach something of the robot's own.

    ``R`` (dof + 1, 3, 3) and ``p`` (dof + 1, 3): after the links the base is written there.
    """
    if _blocked(f, q):
        return True
    base = np.uintp(R.shape[0] - 1)
    for row in range(3):
        p[base, row] = f.p_base[row]
        for col in range(3):
            R[base, row, col] = f.R_base[row, col]
    nothing_held = s.group_start[-2] == s.group_start[-1]
    for n in range(f.held if nothing_held else 0, f.checks.shape[0]):
        g, i, k, j = f.checks[n, 0], f.checks[n, 1], f.checks[n, 2], f.checks[n, 3]
        first, end = s.group_start[g], s.group_start[g + np.uintp(1)]
        x, y, z = _place(R, p, i, s.groups, g)
        dx, dy, dz = x - p[j, 0], y - p[j, 1], z - p[j, 2]
        x = R[j, 0, 0] * dx + R[j, 1, 0] * dy + R[j, 2, 0] * dz
        y = R[j, 0, 1] * dx + R[j, 1, 1] * dy + R[j, 2, 1] * dz
        z = R[j, 0, 2] * dx + R[j, 1, 2] * dy + R[j, 2, 2] * dz
        if _reaches(f, k, x, y, z, s.groups[g, 3]) and _group_hits(s, f, R, p, i, k, j, first, end):
            return True
    return False


@njit(cache=True, fastmath=FAST, error_model="numpy", forceinline=True)
def _group_hits(
    s: SphereArrays,
    f: FieldArrays,
    R: Array,
    p: Array,
    i: int,
    k: int,
    j: int,
    first: int,
    end: int,
) -> bool:
    """Whether spheres of clusters ``first`` to ``end`` of link ``i`` reach field ``k`` of ``j``."""
    a00 = R[j, 0, 0] * R[i, 0, 0] + R[j, 1, 0] * R[i, 1, 0] + R[j, 2, 0] * R[i, 2, 0]
    a01 = R[j, 0, 0] * R[i, 0, 1] + R[j, 1, 0] * R[i, 1, 1] + R[j, 2, 0] * R[i, 2, 1]
    a02 = R[j, 0, 0] * R[i, 0, 2] + R[j, 1, 0] * R[i, 1, 2] + R[j, 2, 0] * R[i, 2, 2]
    a10 = R[j, 0, 1] * R[i, 0, 0] + R[j, 1, 1] * R[i, 1, 0] + R[j, 2, 1] * R[i, 2, 0]
    a11 = R[j, 0, 1] * R[i, 0, 1] + R[j, 1, 1] * R[i, 1, 1] + R[j, 2, 1] * R[i, 2, 1]
    a12 = R[j, 0, 1] * R[i, 0, 2] + R[j, 1, 1] * R[i, 1, 2] + R[j, 2, 1] * R[i, 2, 2]
    a20 = R[j, 0, 2] * R[i, 0, 0] + R[j, 1, 2] * R[i, 1, 0] + R[j, 2, 2] * R[i, 2, 0]
    a21 = R[j, 0, 2] * R[i, 0, 1] + R[j, 1, 2] * R[i, 1, 1] + R[j, 2, 2] * R[i, 2, 1]
    a22 = R[j, 0, 2] * R[i, 0, 2] + R[j, 1, 2] * R[i, 1, 2] + R[j, 2, 2] * R[i, 2, 2]
    dx, dy, dz = p[i, 0] - p[j, 0], p[i, 1] - p[j, 1], p[i, 2] - p[j, 2]
    t0 = R[j, 0, 0] * dx + R[j, 1, 0] * dy + R[j, 2, 0] * dz
    t1 = R[j, 0, 1] * dx + R[j, 1, 1] * dy + R[j, 2, 1] * dz
    t2 = R[j, 0, 2] * dx + R[j, 1, 2] * dy + R[j, 2, 2] * dz
    for c in range(first, end):
        x, y, z = s.clusters[c, 0], s.clusters[c, 1], s.clusters[c, 2]
        if not _reaches(
            f,
            k,
            t0 + a00 * x + a01 * y + a02 * z,
            t1 + a10 * x + a11 * y + a12 * z,
            t2 + a20 * x + a21 * y + a22 * z,
            s.clusters[c, 3],
        ):
            continue
        for m in range(s.cluster_start[c], s.cluster_start[c + np.uintp(1)]):
            x, y, z = s.spheres[m, 0], s.spheres[m, 1], s.spheres[m, 2]
            x, y, z = (
                t0 + a00 * x + a01 * y + a02 * z,
                t1 + a10 * x + a11 * y + a12 * z,
                t2 + a20 * x + a21 * y + a22 * z,
            )
            r = s.spheres[m, 3]
            if _reaches(f, k, x, y, z, r) and not _apart(f, k, x, y, z, r):
                return True
    return False


@njit(cache=True, fastmath=FAST, error_model="numpy")
def is_free(
    chain: ChainArrays,
    s: SphereArrays,
    w: WorldArrays,
    q: Array,
    R: Array,
    p: Array,
    near: IntArray,
) -> bool:
    """Whether the arm at ``q`` (dof,) is clear; ``R``, ``p``, ``near`` are scratch space."""
    link_frames(chain, q, R, p)
    last = q.shape[0] - 1
    if s.min_up > -1.0:
        up = R[last, 2, 0] * s.up[0] + R[last, 2, 1] * s.up[1] + R[last, 2, 2] * s.up[2]
        if up < s.min_up:
            return False
    # The hand is the likeliest to touch something: from the last link to the first.
    for back in range(q.shape[0] - w.active_from):
        i = last - back
        x, y, z = _place(R, p, i, s.links, i)
        count = _shortlist(w, x, y, z, s.links[i, 3] + w.margin, near)
        if count == 0:
            continue
        for c in range(s.link_start[i], s.link_start[i + 1]):
            if _cluster_hits(s, w, R, p, i, c, near, count):
                return False
    return not _meets_itself(chain.fields, s, q, R, p)


@njit(cache=True, error_model="numpy")
def free_batch(
    chain: ChainArrays, s: SphereArrays, w: WorldArrays, configurations: Array
) -> BoolArray:
    """Which configurations (k, dof) are free."""
    count, dof = configurations.shape
    R, p = np.empty((dof + 1, 3, 3)), np.empty((dof + 1, 3))
    near = np.empty(2 * w.centre.shape[0], dtype=np.uintp)
    result = np.empty(count, dtype=np.bool_)
    for n in range(count):
        result[n] = is_free(chain, s, w, configurations[n], R, p, near)
    return result


@njit(cache=True, error_model="numpy")
def hands_free(s: SphereArrays, w: WorldArrays, last_link_frames: Array) -> BoolArray:
    """Which poses (k, 4, 4) of the last link keep it, and so the hand, clear."""
    last = s.links.shape[0] - 1
    R, p = np.empty((last + 1, 3, 3)), np.empty((last + 1, 3))
    near = np.empty(2 * w.centre.shape[0], dtype=np.uintp)
    result = np.ones(last_link_frames.shape[0], dtype=np.bool_)
    for n in range(last_link_frames.shape[0]):
        for i in range(3):
            p[last, i] = last_link_frames[n, i, 3]
            for j in range(3):
                R[last, i, j] = last_link_frames[n, i, j]
        x, y, z = _place(R, p, last, s.links, last)
        count = _shortlist(w, x, y, z, s.links[last, 3] + w.margin, near)
        for c in range(s.link_start[last], s.link_start[last + 1]):
            if _cluster_hits(s, w, R, p, last, c, near, count):
                result[n] = False
                break
    return result


@njit(cache=True, error_model="numpy")
def edge_steps(chain: ChainArrays, a: Array, b: Array) -> int:
    """Number of pieces an edge is cut into, so that nothing travels more than EDGE_STEP in one."""
    travel = 0.0
    for j in range(a.shape[0]):
        travel += abs(b[j] - a[j]) * chain.reach[j]
    return max(1, int(np.ceil(travel / EDGE_STEP)))


@njit(cache=True, error_model="numpy")
def edge_is_free(
    chain: ChainArrays,
    s: SphereArrays,
    w: WorldArrays,
    a: Array,
    b: Array,
    R: Array,
    p: Array,
    near: IntArray,
    checks: IntArray,
) -> bool:
    """Whether the straight motion from ``a`` to ``b`` is free, ``a`` itself not checked.

    Midpoints first (van der Corput order): a blocked edge shows early. Adds to ``checks[0]``.
    """
    steps = edge_steps(chain, a, b)
    q = np.empty(a.shape[0])
    stride = 1
    while stride < steps:
        stride *= 2
    checks[0] += 1
    if not is_free(chain, s, w, b, R, p, near):
        return False
    while stride > 1:
        half = stride // 2
        for n in range(half, steps, stride):
            fraction = n / steps
            for j in range(a.shape[0]):
                q[j] = a[j] + fraction * (b[j] - a[j])
            checks[0] += 1
            if not is_free(chain, s, w, q, R, p, near):
                return False
        stride = half
    return True


@njit(cache=True, error_model="numpy")
def edges_batch(
    chain: ChainArrays, s: SphereArrays, w: WorldArrays, starts: Array, ends: Array
) -> BoolArray:
    """Which straight motions between configurations (k, dof), both ends included, are free."""
    count, dof = starts.shape
    R, p = np.empty((dof + 1, 3, 3)), np.empty((dof + 1, 3))
    near = np.empty(2 * w.centre.shape[0], dtype=np.uintp)
    checks = np.zeros(1, dtype=np.int64)
    result = np.empty(count, dtype=np.bool_)
    for n in range(count):
        result[n] = is_free(chain, s, w, starts[n], R, p, near) and edge_is_free(
            chain, s, w, starts[n], ends[n], R, p, near, checks
        )
    return result


@njit(cache=True, error_model="numpy")
def sweep_heights(
    chain: ChainArrays,
    s: SphereArrays,
    path: Array,
    origin: Array,
    resolution: float,
    lowest: Array,
) -> None:
    """Lower ``lowest`` (nx, ny) to the lowest height the spheres reach over each cell.

    ``path`` (k, dof) is followed straight from one configuration to the next. A cell counts the
    nearest point of its square to each sphere, so nothing is missed.
    """
    dof = path.shape[1]
    R, p = np.empty((dof + 1, 3, 3)), np.empty((dof + 1, 3))
    q = np.empty(dof)
    for n in range(path.shape[0]):
        steps = 1
        if n > 0:
            steps = edge_steps(chain, path[n - 1], path[n])
        for m in range(1, steps + 1):
            for j in range(dof):
                before = path[max(n - 1, 0), j]
                q[j] = before + (m / steps) * (path[n, j] - before)
            link_frames(chain, q, R, p)
            for i in range(dof):
                for c in range(s.link_start[i], s.link_start[i + 1]):
                    for k in range(s.cluster_start[c], s.cluster_start[c + 1]):
                        x, y, z = _place(R, p, i, s.spheres, k)
                        _stamp(x, y, z, s.spheres[k, 3], origin, resolution, lowest)


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _stamp(
    x: float, y: float, z: float, r: float, origin: Array, resolution: float, lowest: Array
) -> None:
    nx, ny = lowest.shape
    i0 = max(int(np.floor((x - r - origin[0]) / resolution)), 0)
    i1 = min(int(np.floor((x + r - origin[0]) / resolution)), nx - 1)
    j0 = max(int(np.floor((y - r - origin[1]) / resolution)), 0)
    j1 = min(int(np.floor((y + r - origin[1]) / resolution)), ny - 1)
    bottom = z - r
    for i in range(i0, i1 + 1):
        left = origin[0] + i * resolution
        dx = max(left - x, x - left - resolution, 0.0)
        for j in range(j0, j1 + 1):
            # The arm comes back the way it went: most cells are as low already.
            if lowest[i, j] <= bottom:
                continue
            near_side = origin[1] + j * resolution
            dy = max(near_side - y, y - near_side - resolution, 0.0)
            rest = r * r - dx * dx - dy * dy
            if rest > 0.0:
                height = z - np.sqrt(rest)
                lowest[i, j] = min(lowest[i, j], height)
