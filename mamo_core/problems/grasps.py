"""Grasps of a target that the problem does not list itself."""

from __future__ import annotations

from dataclasses import replace

from mamo_core.robots.grasps import LEAST_COVERED, TOP_GAP, Hand, dipped_grasps, side_grasps
from mamo_core.types.problem import Grasp
from mamo_core.types.scene import SceneObject

MORE_HEIGHTS = (0.18, 0.2, 0.105, 0.135, 0.05)
"""Tool heights above the bottom for places where the usual ones do not work, m."""

DIPS = (0.25, 0.5, 0.15, 0.35)
"""How far the hand is dipped, rad."""


def default_grasps(target: SceneObject, hand: Hand, *, first_yaw: float = 0.0) -> tuple[Grasp, ...]:
    """Grasps of an upright ``target``, those that work most often first.

    Side grasps at the usual heights, those nearest ``first_yaw`` (rad) first; then at other
    heights; then from above with the hand dipped; then by the fingertips, where the hand finds no
    room between what stands beside the target.
    """
    shape = target.shape
    fingertips = replace(hand, depth=min(hand.depth, LEAST_COVERED))
    others = tuple(h for h in MORE_HEIGHTS if h <= shape.height - TOP_GAP)
    return (
        *side_grasps(shape, hand, first_yaw=first_yaw),
        *(side_grasps(shape, hand, first_yaw=first_yaw, heights=others) if others else ()),
        *dipped_grasps(shape, hand, first_yaw=first_yaw, pitches=DIPS),
        *side_grasps(shape, fingertips, first_yaw=first_yaw),
        *(side_grasps(shape, fingertips, first_yaw=first_yaw, heights=others) if others else ()),
    )
