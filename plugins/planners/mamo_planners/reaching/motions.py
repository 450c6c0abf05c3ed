"""Joint paths as timed segments of a plan."""

from __future__ import annotations

import numpy as np

from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import interpolated, time_path
from mamo_core.types.geometry import Array
from mamo_core.types.motion import MotionSegment, SegmentKind, Trajectory
from mamo_planners.reaching.options import MotionOptions

_GRIPPER_TIME = 0.5
_TOOL_SPEED_STEP = 0.1


class Motions:
    """Segments with the hand at ``opening`` (m)."""

    def __init__(
        self, arm: ArmModel, kinematics: Kinematics, options: MotionOptions, opening: float
    ) -> None:
        self._arm, self._kinematics, self._options = arm, kinematics, options
        self._opening = opening

    def opened(self, q: Array) -> MotionSegment:
        """The hand opens, the arm at ``q`` (dof,)."""
        still = Trajectory(np.array([0.0, _GRIPPER_TIME]), np.stack([q, q]))
        return MotionSegment(SegmentKind.GRIPPER, still, self._opening, contact_free=True)

    def transit(self, path: Array) -> MotionSegment:
        """A path (k, dof) on which the arm touches nothing."""
        timed = time_path(path, self._arm.velocity, scale=self._options.joint_speed)
        return MotionSegment(SegmentKind.TRANSIT, timed, self._opening, contact_free=True)

    def sweep(self, path: Array) -> MotionSegment:
        """A path (k, dof) on which the arm may push movables: the tool keeps to its speed."""
        rows = interpolated(path, _TOOL_SPEED_STEP)
        timed = time_path(
            rows,
            self._arm.velocity,
            scale=self._options.joint_speed,
            tool_positions=np.array([self._kinematics.forward(q)[:3, 3] for q in rows]),
            tool_speed=self._options.sweep_speed,
        )
        settle = self._options.settle
        return MotionSegment(SegmentKind.SWEEP, timed, self._opening, settle=settle)
