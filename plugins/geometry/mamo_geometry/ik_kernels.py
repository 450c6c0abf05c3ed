"""Compiled inverse kinematics: damped least squares with restarts, and straight tool lines."""

from __future__ import annotations

import numpy as np
from numba import njit

from mamo_core.types.geometry import Array
from mamo_geometry.arrays import ChainArrays
from mamo_geometry.kernels import link_frames

_POSITION_TOLERANCE = 1e-5
_ROTATION_TOLERANCE = 1e-4
_ITERATIONS = 60
_PATIENCE = 8
_DAMPING = 1e-4
_LONGEST_STEP = 0.3
_JUMP = 0.25


@njit(cache=True, error_model="numpy")
def tool_frame(chain: ChainArrays, q: Array, R: Array, p: Array, T: Array) -> None:
    """Tool frame ``T`` (3, 4) in the world at ``q``; ``R``, ``p`` receive the link frames."""
    link_frames(chain, q, R, p)
    last = q.shape[0] - 1
    for row in range(3):
        for col in range(4):
            value = p[last, row] if col == 3 else 0.0
            for k in range(3):
                value += R[last, row, k] * chain.tool[k, col]
            T[row, col] = value


@njit(cache=True, error_model="numpy")
def fill_jacobian(chain: ChainArrays, R: Array, p: Array, T: Array, J: Array) -> None:
    """Geometric Jacobian ``J`` (6, dof) of the tool origin: linear rows, then angular ones."""
    for j in range(J.shape[1]):
        ax = R[j, 0, 0] * chain.axis[j, 0] + R[j, 0, 1] * chain.axis[j, 1]
        ay = R[j, 1, 0] * chain.axis[j, 0] + R[j, 1, 1] * chain.axis[j, 1]
        az = R[j, 2, 0] * chain.axis[j, 0] + R[j, 2, 1] * chain.axis[j, 1]
        ax += R[j, 0, 2] * chain.axis[j, 2]
        ay += R[j, 1, 2] * chain.axis[j, 2]
        az += R[j, 2, 2] * chain.axis[j, 2]
        if abs(chain.slide[j, 0]) + abs(chain.slide[j, 1]) + abs(chain.slide[j, 2]) > 0.0:
            J[0, j], J[1, j], J[2, j] = ax, ay, az
            J[3, j] = J[4, j] = J[5, j] = 0.0
            continue
        x, y, z = T[0, 3] - p[j, 0], T[1, 3] - p[j, 1], T[2, 3] - p[j, 2]
        J[0, j], J[1, j], J[2, j] = ay * z - az * y, az * x - ax * z, ax * y - ay * x
        J[3, j], J[4, j], J[5, j] = ax, ay, az


@njit(cache=True, error_model="numpy")
def rotation_vector(W: Array, out: Array) -> None:
    """Rotation vector (3,) of a rotation matrix (3, 3)."""
    x, y, z = W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]
    sine = 0.5 * np.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (W[0, 0] + W[1, 1] + W[2, 2] - 1.0)
    angle = np.arctan2(sine, cosine)
    if sine > 1e-9:
        factor = 0.5 * angle / sine
        out[0], out[1], out[2] = factor * x, factor * y, factor * z
    elif cosine > 0.0:
        out[0], out[1], out[2] = 0.5 * x, 0.5 * y, 0.5 * z
    else:
        # Half a turn: the axis is the largest column of (W + I) / 2.
        k = 0
        if W[1, 1] > W[k, k]:
            k = 1
        if W[2, 2] > W[k, k]:
            k = 2
        length = np.sqrt(max(0.5 * (W[k, k] + 1.0), 1e-12))
        for i in range(3):
            entry = W[i, k] + (1.0 if i == k else 0.0)
            out[i] = np.pi * 0.5 * entry / length


@njit(cache=True, error_model="numpy")
def _tool_error(T: Array, goal: Array, W: Array, w: Array, e: Array) -> None:
    """Position and rotation error (6,) from the tool frame to the goal, in the world."""
    for i in range(3):
        e[i] = goal[i, 3] - T[i, 3]
        for j in range(3):
            value = 0.0
            for k in range(3):
                value += goal[i, k] * T[j, k]
            W[i, j] = value
    rotation_vector(W, w)
    e[3], e[4], e[5] = w[0], w[1], w[2]


@njit(cache=True, error_model="numpy")
def _solve6(M: Array, e: Array) -> None:
    """Solve M x = e in place for a symmetric positive definite M (6, 6), by Cholesky."""
    for i in range(6):
        for j in range(i + 1):
            value = M[i, j]
            for k in range(j):
                value -= M[i, k] * M[j, k]
            if i == j:
                M[i, i] = np.sqrt(max(value, 1e-15))
            else:
                M[i, j] = value / M[j, j]
    for i in range(6):
        for k in range(i):
            e[i] -= M[i, k] * e[k]
        e[i] /= M[i, i]
    for back in range(6):
        i = 5 - back
        for k in range(i + 1, 6):
            e[i] -= M[k, i] * e[k]
        e[i] /= M[i, i]


@njit(cache=True, error_model="numpy")
def descend(chain: ChainArrays, q: Array, goal: Array) -> bool:
    """Move ``q`` (dof,) until the tool is at ``goal`` (3, 4); False if that fails."""
    dof = q.shape[0]
    R, p, T = np.empty((dof, 3, 3)), np.empty((dof, 3)), np.empty((3, 4))
    J, M, W = np.empty((6, dof)), np.empty((6, 6)), np.empty((3, 3))
    e, w = np.empty(6), np.empty(3)
    before = np.inf
    for n in range(_ITERATIONS):
        tool_frame(chain, q, R, p, T)
        _tool_error(T, goal, W, w, e)
        off = np.sqrt(e[0] ** 2 + e[1] ** 2 + e[2] ** 2)
        turned = np.sqrt(e[3] ** 2 + e[4] ** 2 + e[5] ** 2)
        if off < _POSITION_TOLERANCE and turned < _ROTATION_TOLERANCE:
            return True
        if n % _PATIENCE == _PATIENCE - 1:
            # Stuck at a limit or in a local minimum: another seed is the better bet.
            if off + turned > 0.6 * before:
                return False
            before = off + turned
        fill_jacobian(chain, R, p, T, J)
        damping = _DAMPING + 1e-2 * min(off + turned, 1.0) ** 2
        for i in range(6):
            for j in range(i + 1):
                value = damping if i == j else 0.0
                for k in range(dof):
                    value += J[i, k] * J[j, k]
                M[i, j] = value
        _solve6(M, e)
        longest = 0.0
        for k in range(dof):
            step = 0.0
            for i in range(6):
                step += J[i, k] * e[i]
            w_k = step
            J[0, k] = w_k
            longest = max(longest, abs(w_k))
        scale = min(1.0, _LONGEST_STEP / longest) if longest > 0.0 else 1.0
        for k in range(dof):
            q[k] = min(max(q[k] + scale * J[0, k], chain.lower[k]), chain.upper[k])
    return False


@njit(cache=True, error_model="numpy")
def inverse_batch(
    chain: ChainArrays, goal: Array, seeds: Array, home: Array, apart: float, found: Array
) -> int:
    """Fill ``found`` (wanted, dof) with distinct solutions from ``seeds`` (m, dof) in their order.

    Turns of joints with more than a full range are brought as close to ``home`` (dof,) as the
    limits allow. Solutions closer than ``apart`` (rad, every joint) to an earlier one are dropped.
    Returns their number.
    """
    dof = home.shape[0]
    count = 0
    q = np.empty(dof)
    for n in range(seeds.shape[0]):
        copy_row(seeds, n, q)
        if not descend(chain, q, goal):
            continue
        for j in range(dof):
            slide = abs(chain.slide[j, 0]) + abs(chain.slide[j, 1]) + abs(chain.slide[j, 2])
            if slide == 0.0 and chain.upper[j] - chain.lower[j] > 2.0 * np.pi:
                q[j] = _turned_home(q[j], home[j], chain.lower[j], chain.upper[j])
        fresh = True
        for k in range(count):
            if row_gap(found, k, q) < apart:
                fresh = False
                break
        if fresh:
            for j in range(dof):
                found[count, j] = q[j]
            count += 1
            if count == found.shape[0]:
                break
    return count


@njit(cache=True, error_model="numpy")
def _turned_home(angle: float, home: float, lower: float, upper: float) -> float:
    """``angle`` (within limits) turned as close to home as whole turns within limits bring it."""
    turn = 2.0 * np.pi
    turns = np.round((angle - home) / turn)
    while turns > 0.0 and angle - turns * turn < lower:
        turns -= 1.0
    while turns < 0.0 and angle - turns * turn > upper:
        turns += 1.0
    return float(angle - turns * turn)


# Slices and whole-array expressions would read better here and below, but they compile slowly.


@njit(cache=True, error_model="numpy")
def copy_row(rows: Array, n: int, q: Array) -> None:
    """Write row ``n`` into ``q``."""
    for j in range(q.shape[0]):
        q[j] = rows[n, j]


@njit(cache=True, error_model="numpy")
def row_gap(rows: Array, n: int, q: Array) -> float:
    """Largest difference between row ``n`` and ``q``."""
    gap = 0.0
    for j in range(q.shape[0]):
        gap = max(gap, abs(rows[n, j] - q[j]))
    return gap


@njit(cache=True, error_model="numpy")
def line_path(chain: ChainArrays, start: Array, goal: Array, path: Array) -> int:
    """Fill ``path`` (steps + 1, dof): the tool moves evenly from ``start`` to ``goal`` (3, 4).

    Returns how many rows could be filled before a step failed or jumped.
    """
    dof, steps = start.shape[0], path.shape[0] - 1
    R, p = np.empty((dof, 3, 3)), np.empty((dof, 3))
    T0, T = np.empty((3, 4)), np.empty((3, 4))
    W, w, e = np.empty((3, 3)), np.empty(3), np.empty(6)
    tool_frame(chain, start, R, p, T0)
    _tool_error(T0, goal, W, w, e)
    q = start.copy()
    for j in range(dof):
        path[0, j] = q[j]
    for n in range(1, steps + 1):
        _turned(T0, e, n / steps, W, T)
        if not descend(chain, q, T) or row_gap(path, n - 1, q) > _JUMP:
            return n
        for j in range(dof):
            path[n, j] = q[j]
    return steps + 1


@njit(cache=True, error_model="numpy")
def _turned(T0: Array, e: Array, fraction: float, Q: Array, T: Array) -> None:
    """``T0`` moved by ``fraction`` of the displacement and rotation vector ``e`` (6,)."""
    x, y, z = fraction * e[3], fraction * e[4], fraction * e[5]
    angle = np.sqrt(x * x + y * y + z * z)
    if angle > 1e-12:
        x, y, z = x / angle, y / angle, z / angle
    s, c = np.sin(angle), 1.0 - np.cos(angle)
    Q[0, 0], Q[0, 1], Q[0, 2] = 1.0 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y
    Q[1, 0], Q[1, 1], Q[1, 2] = c * x * y + s * z, 1.0 - c * (x * x + z * z), c * y * z - s * x
    Q[2, 0], Q[2, 1], Q[2, 2] = c * x * z - s * y, c * y * z + s * x, 1.0 - c * (x * x + y * y)
    for i in range(3):
        T[i, 3] = T0[i, 3] + fraction * e[i]
        for j in range(3):
            T[i, j] = Q[i, 0] * T0[0, j] + Q[i, 1] * T0[1, j] + Q[i, 2] * T0[2, j]
