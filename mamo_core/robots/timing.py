"""Time parametrisation of joint paths within velocity limits."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from mamo_core.types.geometry import Array
from mamo_core.types.motion import Trajectory

_RAMP = 0.2


def time_path(
    path: Array,
    velocity_limits: Array,
    *,
    scale: float,
    tool_positions: Array | None = None,
    tool_speed: float = np.inf,
) -> Trajectory:
    """Follow ``path`` (k, dof) as fast as ``scale`` times the limits (dof,) allow.

    With ``tool_positions`` (k, 3) the tool stays below ``tool_speed`` m/s, too. Speed ramps up
    and down over 0.2 s at the ends. A path of one configuration becomes a short stop.
    """
    steps = np.abs(np.diff(path, axis=0))
    durations = (steps / (scale * velocity_limits)).max(axis=1, initial=0.0)
    if tool_positions is not None and len(path) > 1:
        lengths = np.linalg.norm(np.diff(tool_positions, axis=0), axis=1)
        durations = np.maximum(durations, lengths / tool_speed)
    moving = durations > 1e-9
    if not moving.any():
        return Trajectory(np.array([0.0]), path[:1])
    progress = np.concatenate([[0.0], np.cumsum(durations[moving])])
    points = np.vstack([path[:1], path[1:][moving]])
    # Cut long pieces so that the ramps are followed closely.
    fine = np.unique(np.concatenate([progress, np.arange(0.0, progress[-1], 0.02)]))
    fine = fine[np.concatenate([[True], np.diff(fine) > 1e-9])]
    fine[-1] = progress[-1]
    positions = np.stack([np.interp(fine, progress, column) for column in points.T], axis=1)
    return Trajectory(_ramped(fine), positions)


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
