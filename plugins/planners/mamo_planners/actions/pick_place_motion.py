"""The motion of a pick and place, put together from its checked pieces."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import gripper_seconds, interpolated, time_path
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_planners.actions.handling import Drop, Pickup
from mamo_planners.options import PickPlaceOptions

_TOOL_SPEED_STEP = 0.1


class MotionMaker:
    """Times paths and labels them."""

    def __init__(self, arm: ArmModel, kinematics: Kinematics, options: PickPlaceOptions) -> None:
        self._arm, self._kinematics, self._options = arm, kinematics, options

    def motion(
        self,
        name: str,
        pickup: Pickup,
        drop: Drop,
        first: Array | None,
        transit: Array,
        carry: Array,
        last: Array | None,
    ) -> Motion:
        """Pick object ``name`` up and put it down.

        Paths (k, dof): ``first`` to where the gripper opens and ``last`` to where it closes, None
        where it does so at once; ``transit`` to the reach, ``carry`` from the lift to the lowering.
        """
        o, closed = self._options, self._arm.gripper.closed
        # Closing and letting go have to keep clear of everything but the object, too.
        opening, width = pickup.opening, pickup.width
        segments: list[MotionSegment] = []
        if first is not None:
            segments.append(self._free(first, np.inf, closed))
        segments += [
            self._gripper(transit[0], closed, opening, contact_free=True),
            self._free(transit, np.inf, opening),
            self._free(pickup.reach, o.reach_speed, opening, SegmentKind.REACH),
            self._gripper(pickup.reach[-1], opening, width, contact_free=True, closes_on=name),
            self._held(pickup.lift, o.lift_speed, width, name, SegmentKind.LIFT),
            self._held(carry, o.carry_speed, width, name, SegmentKind.CARRY),
            self._held(drop.lower, o.lift_speed, width, name, SegmentKind.CARRY),
            self._gripper(
                drop.lower[-1], width, opening, contact_free=True, settle=o.settle, closes_on=name
            ),
            self._free(drop.retract, o.reach_speed, opening, SegmentKind.RETRACT),
        ]
        if last is not None:
            segments.append(self._free(last, np.inf, opening))
        end = segments[-1].trajectory.positions[-1]
        segments.append(self._gripper(end, opening, closed, contact_free=True))
        return Motion(tuple(segments), closed)

    def _free(
        self, path: Array, speed: float, opening: float, kind: SegmentKind = SegmentKind.TRANSIT
    ) -> MotionSegment:
        return MotionSegment(kind, self._timed(path, speed), opening, contact_free=True)

    def _held(
        self, path: Array, speed: float, grip: float, name: str, kind: SegmentKind
    ) -> MotionSegment:
        timed = self._timed(path, speed)
        return MotionSegment(kind, timed, grip, held=name, contact_free=True)

    def _gripper(
        self,
        q: Array,
        before: float,
        opening: float,
        *,
        contact_free: bool,
        settle: float = 0.0,
        closes_on: str | None = None,
    ) -> MotionSegment:
        still = Trajectory.still(q, gripper_seconds(self._arm.gripper, before, opening))
        return MotionSegment(
            SegmentKind.GRIPPER,
            still,
            opening,
            contact_free=contact_free,
            settle=settle,
            closes_on=closes_on,
        )

    def _timed(self, path: Array, speed: float) -> Trajectory:
        rows = interpolated(path, _TOOL_SPEED_STEP) if np.isfinite(speed) else path
        return time_path(
            rows,
            self._arm.limits,
            scale=self._options.joint_speed,
            tool_positions=self._tools(rows),
            tool_speed=speed,
        )

    def _tools(self, path: Iterable[Array]) -> Array:
        return np.array([self._kinematics.forward(q)[:3, 3] for q in path])
