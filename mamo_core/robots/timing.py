"""Time parametrisation of joint paths within limits of velocity, acceleration and jerk."""

from __future__ import annotations

import numpy as np

from mamo_core.robots.limits import JointLimits
from mamo_core.robots.model import GripperModel
from mamo_core.robots.timing_kernels import smooth_rows
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Trajectory

BLEND = 0.002
"""How far (rad, each joint) a trajectory leaves its path at a corner that has no others near.

Corners that are near each other add up; where the jerk limit needs more than a twentieth of a
second to build up the acceleration, blends are longer and wider.
"""

ROW_STEP = 0.02
"""About the time between two rows, s."""

_RAMP = 0.2
_WINDOW = 0.05
"""Corners are blended for about this long, s: narrower is closer to the path and slower."""


def time_path(
    path: Array,
    limits: JointLimits,
    *,
    scale: float,
    tool_positions: Array | None = None,
    tool_speed: float = np.inf,
) -> Trajectory:
    """Follow ``path`` (k, dof) as fast as ``scale`` times the velocity limits allow, rest to rest.

    Acceleration and jerk stay within their limits. With ``tool_positions`` (k, 3) the tool stays
    below ``tool_speed`` m/s, too. Speed takes 0.2 s at least to build up and to fall, and corners
    are cut by at most ``BLEND``. Rows are even in time.
    """
    steps = np.abs(path[1:] - path[:-1])
    durations = (steps / (scale * limits.velocity)).max(axis=1, initial=0.0)
    if tool_positions is not None and len(path) > 1:
        lengths = np.linalg.norm(tool_positions[1:] - tool_positions[:-1], axis=1)
        durations = np.maximum(durations, lengths / tool_speed)
    moving = durations > 1e-9
    if not moving.any():
        return Trajectory.still(path[0], 0.0)
    points = np.vstack([path[:1], path[1:][moving]])
    taps = np.ceil((limits.acceleration / limits.jerk).max() / ROW_STEP)
    step, positions, velocities = smooth_rows(
        points,
        durations[moving],
        # Copies: read-only arrays would have the kernels compiled once more.
        np.array(limits.acceleration, dtype=np.float64),
        np.array(limits.jerk, dtype=np.float64),
        _RAMP,
        ROW_STEP,
        max(int(taps), round(_WINDOW / ROW_STEP)),
        BLEND,
    )
    return Trajectory(np.arange(len(positions)) * step, positions, velocities)


def gripper_seconds(gripper: GripperModel, before: float, after: float) -> float:
    """How long the fingers take from one opening (m) to another."""
    return abs(after - before) / gripper.speed


def interpolated(path: Array, step: float) -> Array:
    """The path (k, dof) with no joint moving more than ``step`` (rad) between rows."""
    ways = np.diff(path, axis=0)
    counts = np.maximum(1, np.ceil(np.abs(ways).max(axis=1, initial=0.0) / step)).astype(np.int64)
    pieces = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(1, len(pieces) + 1) - np.repeat(np.cumsum(counts) - counts, counts)
    shares = (within / counts[pieces])[:, None]
    return np.vstack([path[:1], path[:-1][pieces] + ways[pieces] * shares])


def sampled(trajectory: Trajectory, step: float) -> Array:
    """Positions (k, dof) of a trajectory with no joint moving more than ``step`` (rad) between."""
    times, positions, velocities = trajectory.times, trajectory.positions, trajectory.velocities
    lengths = np.diff(times)[:, None]
    begin, end = velocities[:-1], velocities[1:]
    # The velocity on a cubic is a parabola, which lies within its Bezier points.
    middle = 3.0 * np.diff(positions, axis=0) / lengths - begin - end
    fastest = np.abs(np.stack([begin, middle, end])).max(axis=0)
    furthest = (lengths * fastest).max(axis=1, initial=0.0)
    counts = np.maximum(1, np.ceil(furthest / step)).astype(np.int64)
    pieces = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(1, len(pieces) + 1) - np.repeat(np.cumsum(counts) - counts, counts)
    at = times[:-1][pieces] + within / counts[pieces] * lengths[:, 0][pieces]
    return np.vstack([positions[:1], trajectory.at(at)])
