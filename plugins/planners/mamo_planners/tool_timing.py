"""Joint paths timed so that the tool, or a point of it, keeps to a speed."""

from __future__ import annotations

import numpy as np

from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import interpolated, time_path
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Trajectory

_STEP = 0.1


def timed_for_tool(
    path: Array,
    arm: ArmModel,
    kinematics: Kinematics,
    *,
    joint_speed: float,
    tool_speed: float,
    T_tool_point: Array | None = None,
) -> Trajectory:
    """Follow ``path`` (k, dof) at a share ``joint_speed`` of the velocity limits.

    The point (4, 4) of the tool, its origin by default, is no faster than ``tool_speed`` (m/s).
    """
    if np.isfinite(tool_speed):
        path = interpolated(path, _STEP)
    T = np.eye(4) if T_tool_point is None else T_tool_point
    return time_path(
        path,
        arm.limits,
        scale=joint_speed,
        tool_positions=np.array([(kinematics.forward(q) @ T)[:3, 3] for q in path]),
        tool_speed=tool_speed,
    )
