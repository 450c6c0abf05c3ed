"""The grasps that pick and place tries, as arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mamo_core.robots.grasps import (
    HANDS,
    Hand,
    dipped_grasps,
    side_grasps,
    widths_between_fingers,
)
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, Shape, matrices_from_poses

_HEIGHTS = (0.04, 0.065, 0.09, 0.12, 0.15, 0.18, 0.21, 0.24, 0.27)
_CLEARANCE, _OPENING_SLACK = 0.01, 5e-4


@dataclass(frozen=True, eq=False)
class GraspSet:
    """Grasps of one shape: ``T_object_tool`` (n, 4, 4); ``openings``, ``approaches`` (n,), m.

    ``widths`` (n,): of the shape between the fingers, m.
    """

    T_object_tool: Array
    openings: Array
    approaches: Array
    widths: Array

    def __len__(self) -> int:
        return len(self.openings)


def grasps_of(shape: Shape, arm: ArmModel) -> GraspSet:
    """Side grasps at many heights, and dipped ones near the top; none if no face fits."""
    hand = _hand(arm)
    grasps = (*side_grasps(shape, hand, heights=_HEIGHTS), *dipped_grasps(shape, hand))
    T = matrices_from_poses(np.array([g.T_object_tool for g in grasps]).reshape(-1, 7))
    widths = widths_between_fingers(shape, T)
    openings = np.array([g.opening for g in grasps])
    return GraspSet(T, openings, np.array([g.approach for g in grasps]), widths)


def _hand(arm: ArmModel) -> Hand:
    """What is known of the hand, or else what its model says."""
    known = HANDS.get(arm.name)
    if known is not None:
        return known
    return Hand(arm.gripper.max_opening - _OPENING_SLACK, arm.gripper.depth, _CLEARANCE)
