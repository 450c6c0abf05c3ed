"""The distance that moved objects keep from what must not be touched."""

from dataclasses import replace

import numpy as np
import pytest
from mamo_planners.search.safety import SafetyMargin

from mamo_core.testing.scenes import walled_in
from mamo_core.types.geometry import make_pose
from mamo_core.types.rollout import RolloutResult

PROBLEM = walled_in().problem
WALL, SIDE = 0.25, 0.06


def moved(name, before, after):
    """A rollout that moves ``a`` to a distance from the wall's face, m."""
    states = []
    for gap in (before, after):
        poses = PROBLEM.initial.object_poses.copy()
        poses[0] = make_pose([WALL, SIDE + gap, 0.06])
        states.append(replace(PROBLEM.initial, object_poses=poses))
    return RolloutResult(
        states[1], (), (name,), frozenset(), False, 1.0, 250, segment_states=(states[0],)
    )


@pytest.mark.parametrize(
    ("before", "after", "kept"),
    [(0.1, 0.011, True), (0.1, 0.009, False), (0.005, 0.004, True), (0.005, 0.1, True)],
)
def test_moved_objects_end_away_unless_they_were_close_before(before, after, kept):
    margin = SafetyMargin(PROBLEM, 0.01)
    assert margin.kept(moved("a", before, after)) is kept
    assert margin.kept(moved("w", before, after))


def test_without_a_margin_everything_is_kept():
    assert SafetyMargin(PROBLEM, 0.0).kept(moved("a", 0.1, 0.0))


def test_the_target_is_guarded_too():
    result = moved("a", 0.1, 0.1)
    poses = np.array(result.final_state.object_poses)
    poses[0, :2] = PROBLEM.initial.object_poses[-1, :2] + [0.0, 0.065]
    close = replace(result, final_state=replace(result.final_state, object_poses=poses))
    assert not SafetyMargin(PROBLEM, 0.01).kept(close)
