"""Grasps of a target that the problem does not list itself."""

from __future__ import annotations

from mamo_core.robots.grasps import TOP_GAP, Hand, dipped_grasps, side_grasps
from mamo_core.types.problem import Grasp
from mamo_core.types.scene import SceneObject

MORE_HEIGHTS = (0.18, 0.2, 0.105, 0.135, 0.05)
"""Tool heights above the bottom for places where the usual ones do not work, m."""

DIPS = (0.25, 0.5, 0.15, 0.35)
"""How far the hand is dipped, rad."""


def default_grasps(target: SceneObject, hand: Hand, *, first_yaw: float = 0.0) -> tuple[Grasp, ...]:
    """Grasps of an upright ``target``, those that work most often first.

    Side grasps at the usual heights, those nearest ``first_yaw`` (rad) first; then at other
    heights; then from above with the hand dipped.
    """
    shape = target.shape
    others = tuple(h for h in MORE_HEIGHTS if h <= shape.height - TOP_GAP)
    return (
        *side_grasps(shape, hand, first_yaw=first_yaw),
        *(side_grasps(shape, hand, first_yaw=first_yaw, heights=others) if others else ()),
        *dipped_grasps(shape, hand, first_yaw=first_yaw, pitches=DIPS),
    )
