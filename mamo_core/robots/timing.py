"""Time parametrisation of joint paths within velocity limits."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from mamo_core.types.geometry import Array
from mamo_core.types.motion import Trajectory

_RAMP = 0.2
_CORNER_JUMP = 0.45
_GRID = 0.02
_RAMP_CUTS = 8


def time_path(
    path: Array,
    velocity_limits: Array,
    *,
    scale: float,
    tool_positions: Array | None = None,
    tool_speed: float = np.inf,
    corner_jump: float = _CORNER_JUMP,
) -> Trajectory:
    """Follow ``path`` (k, dof) as fast as ``scale`` times the limits (dof,) allow.

    With ``tool_positions`` (k, 3) the tool stays below ``tool_speed`` m/s, too. Speed builds up and
    falls within 0.2 s, and at corners no joint's speed jumps by more than about ``corner_jump``
    rad/s.
    """
    steps = np.abs(np.diff(path, axis=0))
    durations = (steps / (scale * velocity_limits)).max(axis=1, initial=0.0)
    if tool_positions is not None and len(path) > 1:
        lengths = np.linalg.norm(np.diff(tool_positions, axis=0), axis=1)
        durations = np.maximum(durations, lengths / tool_speed)
    moving = durations > 1e-9
    if not moving.any():
        return Trajectory(np.array([0.0]), path[:1])
    points = np.vstack([path[:1], path[1:][moving]])
    progress = np.concatenate([[0.0], np.cumsum(durations[moving])])
    # Progress is time at full speed; the grid holds every corner.
    grid = np.concatenate([*(_cut(a, b) for a, b in pairwise(progress)), progress[-1:]])
    rates = np.minimum(1.0, _corner_rates(points, progress, grid, corner_jump))
    positions = np.stack([np.interp(grid, progress, column) for column in points.T], axis=1)
    return Trajectory(_times(grid, rates), positions)


def _cut(start: float, end: float) -> Array:
    """Grid from ``start`` to before ``end``: even, and close where speed builds up or falls.

    There, equal steps of time are steps of progress that grow as squares.
    """
    count = max(2, int(np.ceil((end - start) / _GRID)))
    even = np.linspace(start, end, count, endpoint=False)
    ramp = min(_RAMP, end - start) / 2.0 * (np.arange(1, _RAMP_CUTS) / _RAMP_CUTS) ** 2
    grid = np.unique(np.concatenate([even, start + ramp, end - ramp]))
    return grid[np.concatenate([[True], np.diff(grid) > 1e-5 * (end - start)])]


def _corner_rates(points: Array, progress: Array, grid: Array, corner_jump: float) -> Array:
    """Share of full speed allowed at each grid value: low at corners, 0 at both ends."""
    velocities = np.diff(points, axis=0) / np.diff(progress)[:, None]
    jumps = np.abs(np.diff(velocities, axis=0)).max(axis=1, initial=0.0)
    rates = np.full(grid.size, np.inf)
    corners = np.searchsorted(grid, progress[1:-1])
    rates[corners] = corner_jump / np.maximum(jumps, 1e-9)
    rates[[0, -1]] = 0.0
    return rates


def _times(grid: Array, rates: Array) -> Array:
    """Times along the grid with rates raised and lowered by at most 1 per ``_RAMP``."""
    squares = rates**2
    gaps = 2.0 * np.diff(grid) / _RAMP
    for k in range(1, grid.size):
        squares[k] = min(squares[k], squares[k - 1] + gaps[k - 1])
    for k in range(grid.size - 2, -1, -1):
        squares[k] = min(squares[k], squares[k + 1] + gaps[k])
    speeds = np.sqrt(squares)
    return np.concatenate([[0.0], np.cumsum(2.0 * np.diff(grid) / (speeds[1:] + speeds[:-1]))])


def interpolated(path: Array, step: float) -> Array:
    """The path (k, dof) with no joint moving more than ``step`` (rad) between rows."""
    rows = [path[:1]]
    for a, b in pairwise(path):
        count = max(1, int(np.ceil(np.abs(b - a).max() / step)))
        rows.append(a + (b - a) * (np.arange(1, count + 1) / count)[:, None])
    return np.vstack(rows)


def _ramped(progress: Array) -> Array:
    """Times at which a trapezoidal speed profile reaches each progress (both start at 0)."""
    total = progress[-1]
    ramp = min(_RAMP, total)
    times = progress + ramp / 2.0
    early, late = progress < ramp / 2.0, progress > total - ramp / 2.0
    times[early] = np.sqrt(2.0 * ramp * progress[early])
    times[late] = total + ramp - np.sqrt(2.0 * ramp * np.maximum(total - progress[late], 0.0))
    return times
