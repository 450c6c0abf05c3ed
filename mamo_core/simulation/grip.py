"""What the fingers are told while they close on something, hold it, or let it go."""

from __future__ import annotations

from mamo_core.types.motion import MotionSegment


def in_hand(segment: MotionSegment) -> str | None:
    """What the hand has to do with: it is held, or the fingers close on it or let go of it."""
    return segment.held if segment.held is not None else segment.closes_on


def commanded(segment: MotionSegment, before: float, squeeze: float, pinch: float) -> float:
    """The gap (m) that the fingers are sent to by the end of a segment, from ``before`` (m) on.

    ``squeeze``, ``pinch`` (m): as a world has them; fingers that press do not get there.
    """
    if segment.held is not None:
        return segment.opening - pinch
    closing = segment.closes_on is not None and segment.opening < before
    return segment.opening - squeeze if closing else segment.opening
