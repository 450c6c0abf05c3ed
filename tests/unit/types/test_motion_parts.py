"""A motion in three parts: nothing is touched before and after the middle."""

import numpy as np
import pytest

from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory

TRANSIT, SWEEP, RETRACT, REACH, GRIPPER, LIFT, CARRY = (
    SegmentKind.TRANSIT,
    SegmentKind.SWEEP,
    SegmentKind.RETRACT,
    SegmentKind.REACH,
    SegmentKind.GRIPPER,
    SegmentKind.LIFT,
    SegmentKind.CARRY,
)


def segment(kind, opening=0.07, **changes):
    return MotionSegment(kind, Trajectory.still(np.zeros(3), 0.5), opening, **changes)


FREE, TOUCHES = {"contact_free": True}, {"contact_free": False}
HELD, CLOSES = FREE | {"held": "a"}, FREE | {"closes_on": "a"}
MOTIONS = {
    "push": ([(TRANSIT, FREE), (SWEEP, TOUCHES), (RETRACT, FREE), (TRANSIT, FREE)], 1, 2),
    "pick_place": (
        [
            (TRANSIT, FREE),
            (REACH, FREE),
            (GRIPPER, CLOSES),
            (LIFT, HELD),
            (CARRY, HELD),
            (REACH, HELD | TOUCHES),
            (GRIPPER, CLOSES),
            (RETRACT, FREE),
        ],
        2,
        7,
    ),
    "retrieval": (
        [
            (TRANSIT, FREE),
            (REACH, FREE),
            (GRIPPER, CLOSES),
            (LIFT, HELD),
            (CARRY, HELD),
            (TRANSIT, HELD),
        ],
        2,
        4,
    ),
    "nothing is touched": ([(TRANSIT, FREE), (REACH, FREE)], 0, 2),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_parts(name):
    rows, first, last = MOTIONS[name]
    segments = tuple(segment(kind, **changes) for kind, changes in rows)
    before, touching, after = Motion(segments, 0.07).parts()
    assert before == segments[:first]
    assert touching.segments == segments[first:last]
    assert after == segments[last:]


def test_the_middle_begins_with_the_fingers_as_they_are_then():
    segments = (
        segment(TRANSIT, opening=0.03, contact_free=True),
        segment(SWEEP, opening=0.02, contact_free=False),
    )
    _, touching, _ = Motion(segments, 0.01).parts()
    assert touching.opening == 0.03
