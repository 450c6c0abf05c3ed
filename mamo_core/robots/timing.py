"""Time parametrisation of joint paths within velocity limits."""

from __future__ import annotations

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
    steps = np.abs(_steps(path))
    durations = (steps / (scale * velocity_limits)).max(axis=1, initial=0.0)
    if tool_positions is not None and len(path) > 1:
        lengths = np.linalg.norm(_steps(tool_positions), axis=1)
        durations = np.maximum(durations, lengths / tool_speed)
    moving = durations > 1e-9
    if not moving.any():
        return Trajectory(np.array([0.0]), path[:1])
    points = np.vstack([path[:1], path[1:][moving]])
    progress = np.concatenate([[0.0], np.cumsum(durations[moving])])
    # Progress is time at full speed; the grid holds every corner.
    grid = np.append(_cut(progress), progress[-1])
    rates = np.minimum(1.0, _corner_rates(points, progress, grid, corner_jump))
    positions = np.stack([np.interp(grid, progress, column) for column in points.T], axis=1)
    return Trajectory(_times(grid, rates), positions)


def _cut(progress: Array) -> Array:
    """Grid from each value of ``progress`` (k,) to before the next: even, and close at both ends.

    That is where speed builds up or falls: equal steps of time are steps of progress that grow as
    squares.
    """
    starts, ends = progress[:-1], progress[1:]
    lengths = ends - starts
    counts = np.maximum(2, np.ceil(lengths / _GRID).astype(np.int64))
    pieces = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(len(pieces)) - np.repeat(np.cumsum(counts) - counts, counts)
    even = within * (lengths / counts)[pieces] + starts[pieces]
    shares = (np.arange(1, _RAMP_CUTS) / _RAMP_CUTS) ** 2
    ramps = (np.minimum(_RAMP, lengths) / 2.0)[:, None] * shares
    grid = np.concatenate(
        [even, (starts[:, None] + ramps).ravel(), (ends[:, None] - ramps).ravel()]
    )
    # The pieces lie one behind the other, so sorting all of them sorts each.
    grid.sort()
    closest = np.repeat(1e-5 * lengths, counts + 2 * len(shares))
    kept = np.concatenate([[True], _steps(grid) > closest[1:]])
    kept[np.cumsum(counts + 2 * len(shares))[:-1]] = True
    return grid[kept]


def _corner_rates(points: Array, progress: Array, grid: Array, corner_jump: float) -> Array:
    """Share of full speed allowed at each grid value: low at corners, 0 at both ends."""
    velocities = _steps(points) / _steps(progress)[:, None]
    jumps = np.abs(_steps(velocities)).max(axis=1, initial=0.0)
    rates = np.full(grid.size, np.inf)
    corners = np.searchsorted(grid, progress[1:-1])
    rates[corners] = corner_jump / np.maximum(jumps, 1e-9)
    rates[[0, -1]] = 0.0
    return rates


def _times(grid: Array, rates: Array) -> Array:
    """Times along the grid with rates raised and lowered by at most 1 per ``_RAMP``."""
    gaps = (2.0 * _steps(grid) / _RAMP).tolist()
    rising = _limited((rates**2).tolist(), gaps)
    speeds = np.sqrt(_limited(rising[::-1], gaps[::-1])[::-1])
    return np.concatenate([[0.0], np.cumsum(2.0 * _steps(grid) / (speeds[1:] + speeds[:-1]))])


def _limited(squares: list[float], gaps: list[float]) -> list[float]:
    """``squares`` (none above 1), lowered so that none is above the last one by more than its gap.

    After a 1 nothing has to be lowered, so it is enough to go on from the others.
    """
    limited = list(squares)
    for start in [k for k, square in enumerate(squares[:-1]) if square < 1.0]:
        value = limited[start]
        for k in range(start, len(gaps)):
            value += gaps[k]
            if limited[k + 1] <= value:
                break
            limited[k + 1] = value
    return limited


def _steps(values: Array) -> Array:
    """From each row of ``values`` to the next."""
    return values[1:] - values[:-1]


def interpolated(path: Array, step: float) -> Array:
    """The path (k, dof) with no joint moving more than ``step`` (rad) between rows."""
    ways = np.diff(path, axis=0)
    counts = np.maximum(1, np.ceil(np.abs(ways).max(axis=1, initial=0.0) / step)).astype(np.int64)
    pieces = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(1, len(pieces) + 1) - np.repeat(np.cumsum(counts) - counts, counts)
    shares = (within / counts[pieces])[:, None]
    return np.vstack([path[:1], path[:-1][pieces] + ways[pieces] * shares])
