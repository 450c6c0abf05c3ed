"""What pictures show as swept: where a motion passes, and how low."""

from dataclasses import replace

import numpy as np
import pytest

from mamo_core.testing.gantry_arm import gantry_arm
from mamo_core.testing.transition_cases import gantry_cases
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.solution import Plan
from mamo_core.view.swept import swept_region, with_region

PROBLEM = gantry_cases().problem
FLOOR = PROBLEM.scene.workspace.floor
BALL = 0.02
"""Radius of the arm's only sphere, which stands on the tool frame, m."""

GANTRY = gantry_arm()
TOOL = replace(GANTRY.links[-1], spheres=np.array([[0.0, 0.0, BALL, BALL]]))
ARM = replace(GANTRY, links=(*GANTRY.links[:-1], TOOL))
X, Y, HIGH = float(PROBLEM.scene.workspace.lower[0]) + 0.1, 0.0, FLOOR + 0.10


def way(begin, end, held=None):
    """A segment from one tool position to another."""
    positions = np.array([[*begin, 0.0], [*end, 0.0]])
    trajectory = Trajectory.through(np.array([0.0, 1.0]), positions)
    return MotionSegment(SegmentKind.CARRY, trajectory, 0.05, held)


def lowest_at(region, x, y):
    i, j = np.floor((np.array([x, y]) - region.origin) / region.resolution).astype(int)
    return region.lowest[i, j]


def test_the_arm_sweeps_its_way_and_nothing_beside_it():
    motion = Motion((way((X, Y, HIGH), (X + 0.2, Y, HIGH)),), 0.05)
    region = swept_region(PROBLEM, motion, ARM)
    along = [lowest_at(region, X + d, Y) for d in np.linspace(0.0, 0.2, 9)]
    np.testing.assert_allclose(along, HIGH, atol=0.01)
    for x, y in [(X + 0.1, Y + 0.04), (X + 0.1, Y - 0.04), (X + 0.24, Y), (X - 0.04, Y)]:
        assert lowest_at(region, x, y) == np.inf


def test_what_is_held_sweeps_too():
    place = PROBLEM.scene.index("can")
    pose, shape = PROBLEM.initial.object_poses[place], PROBLEM.scene.objects[place].shape
    above = pose[:3] + np.array([0.0, 0.0, shape.height / 2.0 + 0.02])
    end = above + np.array([0.0, 0.1, 0.05])
    bare, full = (
        swept_region(PROBLEM, Motion((way(above, end, held),), 0.05), ARM) for held in (None, "can")
    )
    bottom = pose[2] - shape.height / 2.0
    assert lowest_at(full, *pose[:2]) == pytest.approx(bottom, abs=0.01)
    assert lowest_at(bare, *pose[:2]) > bottom + shape.height
    # In the end the can is 5 cm higher, and as wide as it is.
    assert lowest_at(full, end[0], end[1] + 0.5 * shape.radius) > bottom + 0.03
    assert lowest_at(full, end[0], end[1] + shape.radius + 0.02) == np.inf


def test_the_way_home_is_not_shown():
    home = PROBLEM.home[:3]
    back = way((X, Y, HIGH), home)
    on = way(home, home + np.array([0.0, 0.05, 0.0]))
    both, alone = (
        with_region(PROBLEM, Plan((), Motion(segments, 0.05)), ARM).region
        for segments in ((back, on), (on,))
    )
    np.testing.assert_array_equal(both.lowest, alone.lowest)
    never = Motion((way((X, Y, HIGH), (X + 0.1, Y, HIGH)),), 0.05)
    shown = with_region(PROBLEM, Plan((), never), ARM).region
    assert lowest_at(shown, X + 0.05, Y) < HIGH + 0.01


def test_a_region_that_a_search_has_cleared_stays():
    motion = Motion((way((X, Y, HIGH), (X + 0.2, Y, HIGH)),), 0.05)
    region = swept_region(PROBLEM, motion, ARM)
    plan = Plan((), motion, region)
    assert with_region(PROBLEM, plan, ARM) is plan
