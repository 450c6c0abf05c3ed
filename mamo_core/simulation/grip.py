"""What the fingers are told while they close on something, hold it, or let it go."""

from __future__ import annotations

from mamo_core.types.motion import MotionSegment

SQUEEZE = 0.008
"""How much farther than the gap that an object leaves them the fingers are sent to press it, m.

They do not get there: their servos press with no more than the gripper's force, and reach it long
before, so that an object that is a little narrower than it should be is pressed all the same.
"""


def in_hand(segment: MotionSegment) -> str | None:
    """What the hand has to do with: it is held, or the fingers close on it or let go of it."""
    return segment.held if segment.held is not None else segment.closes_on


def commanded(segment: MotionSegment, before: float) -> float:
    """The gap (m) that the fingers are sent to by the end of a segment, from ``before`` (m) on."""
    closing = segment.closes_on is not None and segment.opening < before
    return segment.opening - SQUEEZE if segment.held is not None or closing else segment.opening
