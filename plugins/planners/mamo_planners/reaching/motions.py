"""Joint paths as timed segments of a plan."""

from __future__ import annotations

from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import gripper_seconds, time_path
from mamo_core.types.geometry import Array
from mamo_core.types.motion import MotionSegment, SegmentKind, Trajectory
from mamo_planners.reaching.options import MotionOptions
from mamo_planners.tool_timing import timed_for_tool


class Motions:
    """Segments with the hand at ``opening`` (m)."""

    def __init__(
        self, arm: ArmModel, kinematics: Kinematics, options: MotionOptions, opening: float
    ) -> None:
        self._arm, self._kinematics, self._options = arm, kinematics, options
        self._opening = opening

    def opened(self, q: Array) -> MotionSegment:
        """The closed hand opens, the arm at ``q`` (dof,)."""
        gripper = self._arm.gripper
        still = Trajectory.still(q, gripper_seconds(gripper, gripper.closed, self._opening))
        return MotionSegment(SegmentKind.GRIPPER, still, self._opening, contact_free=True)

    def transit(self, path: Array) -> MotionSegment:
        """A path (k, dof) on which the arm touches nothing."""
        timed = time_path(path, self._arm.limits, scale=self._options.joint_speed)
        return MotionSegment(SegmentKind.TRANSIT, timed, self._opening, contact_free=True)

    def sweep(self, path: Array) -> MotionSegment:
        """A path (k, dof) on which the arm may push movables: the tool keeps to its speed."""
        timed = timed_for_tool(
            path,
            self._arm,
            self._kinematics,
            joint_speed=self._options.joint_speed,
            tool_speed=self._options.sweep_speed,
        )
        settle = self._options.settle
        return MotionSegment(SegmentKind.SWEEP, timed, self._opening, settle=settle)
