"""The timed segments of a retrieval."""

from __future__ import annotations

import numpy as np

from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import gripper_seconds
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.problem import Problem
from mamo_planners.grasp_candidates import Candidate
from mamo_planners.options import RetrievalOptions
from mamo_planners.tool_timing import timed_for_tool

_ROOMY, _SLOWEST = 0.004, 0.3
"""Beside the target, m, from which the hand goes at full speed, and the least share of it."""


class RetrievalMotion:
    """Makes motions of the paths of one problem's retrievals."""

    def __init__(
        self, problem: Problem, arm: ArmModel, kinematics: Kinematics, options: RetrievalOptions
    ) -> None:
        self._problem, self._arm, self._kinematics = problem, arm, kinematics
        self._options = options
        self._target = problem.scene.objects[problem.scene.target_index]

    def whole(self, chosen: Candidate, transit: Array, carry: Array) -> Motion:
        """Open at home, go to the pre-grasp along ``transit`` (k, dof), take out the target."""
        opening = chosen.grasp.opening
        opened = self._still(self._problem.home, self._arm.gripper.closed, opening)
        gone = self._timed(transit, np.inf)
        return Motion(
            (
                MotionSegment(SegmentKind.GRIPPER, opened, opening, contact_free=True),
                MotionSegment(SegmentKind.TRANSIT, gone, opening, contact_free=True),
                *self.taken_out(chosen, carry, contact_free=True),
            ),
            self._arm.gripper.closed,
        )

    def taken_out(
        self, chosen: Candidate, carry: Array, *, contact_free: bool
    ) -> tuple[MotionSegment, ...]:
        """From the pre-grasp on: reach, close, lift, and along ``carry`` (k, dof) home.

        ``contact_free``: whether the carry has to keep clear of everything.
        """
        options, opening, name = self._options, chosen.grasp.opening, self._target.name
        width = chosen.width
        carried = self._timed(carry, options.carry_speed, chosen.held.T_tool_object)
        return (
            MotionSegment(
                SegmentKind.REACH,
                self._timed(chosen.reach, self._reach_speed(chosen)),
                opening,
                contact_free=True,
            ),
            MotionSegment(
                SegmentKind.GRIPPER,
                self._still(chosen.reach[-1], opening, width),
                width,
                contact_free=True,
                closes_on=name,
            ),
            MotionSegment(
                SegmentKind.LIFT,
                self._timed(chosen.lift, options.reach_speed),
                width,
                held=name,
                contact_free=True,
            ),
            MotionSegment(
                SegmentKind.CARRY if contact_free else SegmentKind.SWEEP,
                carried,
                width,
                held=name,
                contact_free=contact_free,
            ),
        )

    def _reach_speed(self, chosen: Candidate) -> float:
        """Slower where the target nearly fills the hand: servos stray more the faster they go."""
        gap = (chosen.grasp.opening - chosen.width) / 2.0
        return self._options.reach_speed * float(np.clip(gap / _ROOMY, _SLOWEST, 1.0))

    def _timed(self, path: Array, speed: float, T_tool_point: Array | None = None) -> Trajectory:
        """No faster than ``speed`` (m/s) at the tool, or at a point of it."""
        return timed_for_tool(
            path,
            self._arm,
            self._kinematics,
            joint_speed=self._options.joint_speed,
            tool_speed=speed,
            T_tool_point=T_tool_point,
        )

    def _still(self, q: Array, before: float, after: float) -> Trajectory:
        """The arm at ``q`` (dof,) while the fingers move."""
        return Trajectory.still(q, gripper_seconds(self._arm.gripper, before, after))
