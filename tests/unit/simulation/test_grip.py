"""What fingers are told, and what constraints see as held, while they close, hold and let go."""

import numpy as np
import pytest

from mamo_core.simulation.grip import commanded, in_hand
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory

STILL = Trajectory.still(np.zeros(7), 0.5)
SQUEEZE, PINCH = 0.008, 0.002


def segment(opening, **changes):
    return MotionSegment(SegmentKind.GRIPPER, STILL, opening, **changes)


@pytest.mark.parametrize(
    ("changes", "before", "expected"),
    [
        ({}, 0.07, 0.06),
        ({"closes_on": "a"}, 0.07, 0.052),  # closes, and presses
        ({"closes_on": "a"}, 0.052, 0.06),  # lets go
        ({"held": "a"}, 0.052, 0.058),
    ],
)
def test_fingers_press_what_they_close_on_and_hold(changes, before, expected):
    assert commanded(segment(0.06, **changes), before, SQUEEZE, PINCH) == pytest.approx(expected)


def test_what_is_in_the_hand():
    assert in_hand(segment(0.06)) is None
    assert in_hand(segment(0.06, closes_on="a")) == "a"
    assert in_hand(segment(0.06, held="b")) == "b"


def test_a_trial_begins_where_the_fingers_close():
    free = segment(0.07, contact_free=True)
    closing = segment(0.06, contact_free=True, closes_on="a")
    trial = Motion((free, closing), 0.0).after_transit()
    assert trial.segments == (closing,)
    assert trial.opening == 0.07
