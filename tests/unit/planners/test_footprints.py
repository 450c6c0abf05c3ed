"""How far an object reaches, and how far it can slide."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mamo_planners.footprints import Outlines, extent_along, free_slide, overlap

from mamo_core.problems.footprints import footprint, separation
from mamo_core.types.geometry import Box, Cylinder, footprint_corners, make_pose

BOX = Box(np.array([0.2, 0.1, 0.3]))
OPEN = np.array([-9.0, -9.0]), np.array([9.0, 9.0])
QUICK = settings(max_examples=100, deadline=None, derandomize=True)
ANGLES = st.floats(-3.1, 3.1)


def unit(angle):
    return np.array([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize(
    ("degrees", "expected"),
    [
        (0, 0.1),
        (90, 0.05),
        (180, 0.1),
        (-90, 0.05),
        (45, 0.05 * np.sqrt(2)),
        (26.565051177, 0.1118),
    ],
)
def test_extent_of_a_box(degrees, expected):
    found = extent_along(BOX, make_pose([1.0, 2.0, 0.0]), unit(np.radians(degrees)))
    assert found == pytest.approx(expected, abs=1e-4)


def test_extent_turns_with_the_box():
    assert extent_along(BOX, make_pose([0, 0, 0], np.pi / 2), unit(0.0)) == pytest.approx(0.05)


def test_extent_of_a_cylinder():
    for angle in (0.0, 1.0, 2.5):
        assert extent_along(Cylinder(0.04, 0.1), make_pose([0, 0, 0], 0.3), unit(angle)) == 0.04


@QUICK
@given(ANGLES, ANGLES)
def test_the_extent_ends_on_the_outline(yaw, angle):
    pose = make_pose([0.3, -0.2, 0.0], yaw)
    reach = extent_along(BOX, pose, unit(angle))
    corners = footprint_corners(BOX, pose)
    end = pose[:2] + reach * unit(angle)
    edges = np.roll(corners, -1, axis=0) - corners
    inward = np.stack([-edges[:, 1], edges[:, 0]], axis=1)
    inward /= np.linalg.norm(inward, axis=1)[:, None]
    depth = ((end - corners) * inward).sum(axis=1)
    assert depth.min() == pytest.approx(0.0, abs=1e-9)


def steps(direction, count, step=0.01):
    return np.arange(1, count + 1)[:, None] * step * np.asarray(direction, dtype=float)


def test_a_free_slide_is_complete():
    assert free_slide(BOX, make_pose([0, 0, 0]), steps([1, 0], 20), Outlines([]), *OPEN) == 20
    assert free_slide(BOX, make_pose([0, 0, 0]), np.zeros((0, 2)), Outlines([]), *OPEN) == 0


def test_a_slide_stops_before_an_obstacle():
    """The box reaches to 0.1, the obstacle begins at 0.155: five steps of 1 cm."""
    obstacle = footprint_corners(Box(np.array([0.1, 0.1, 0.1])), make_pose([0.205, 0.0, 0.0]))
    assert (
        free_slide(BOX, make_pose([0, 0, 0]), steps([1, 0], 20), Outlines([obstacle]), *OPEN) == 5
    )


def test_a_slide_past_an_obstacle():
    """0.1 wide boxes, centres 0.101 apart across the slide."""
    obstacle = footprint_corners(Box(np.array([0.1, 0.1, 0.1])), make_pose([0.2, 0.101, 0.0]))
    assert (
        free_slide(BOX, make_pose([0, 0, 0]), steps([1, 0], 40), Outlines([obstacle]), *OPEN) == 40
    )
    closer = obstacle - [0.0, 0.002]
    assert free_slide(BOX, make_pose([0, 0, 0]), steps([1, 0], 40), Outlines([closer]), *OPEN) < 10


def test_a_slide_stops_at_the_bounds():
    lower, upper = np.array([-1.0, -0.5]), np.array([0.135, 0.5])
    assert free_slide(BOX, make_pose([0, 0, 0]), steps([1, 0], 20), Outlines([]), lower, upper) == 3
    assert (
        free_slide(BOX, make_pose([0, 0, 0]), steps([-1, 0], 20), Outlines([]), lower, upper) == 20
    )


def test_diagonal_edges_are_seen():
    """A turned square whose bounding box overlaps long before it does."""
    square = Box(np.array([0.1, 0.1, 0.1]))
    obstacle = footprint_corners(square, make_pose([0.16, 0.16, 0.0], np.pi / 4))
    moved = free_slide(
        square, make_pose([0, 0, 0], np.pi / 4), steps([1, 1], 20), Outlines([obstacle]), *OPEN
    )
    # Along the diagonal both turn a face: they meet when the centres are 0.1 apart.
    gap = np.hypot(0.16, 0.16) - 0.1
    assert moved == int(gap / (0.01 * np.sqrt(2)))


SHAPES = st.one_of(
    st.builds(lambda a, b: Box(np.array([a, b, 0.1])), st.floats(0.04, 0.2), st.floats(0.04, 0.2)),
    st.builds(lambda r: Cylinder(r, 0.1), st.floats(0.03, 0.1)),
)


@QUICK
@given(SHAPES, SHAPES, ANGLES, ANGLES, st.floats(0.25, 0.5), ANGLES)
def test_slides_agree_with_exact_distances(shape, other, yaw, other_yaw, distance, angle):
    """Free as far as it says; at the next step the circumscribed outlines touch."""
    pose = make_pose([0, 0, 0], yaw)
    other_pose = make_pose([distance, 0.0, 0.0], other_yaw)
    moves = steps(unit(angle), 50)
    count = free_slide(shape, pose, moves, Outlines([footprint_corners(other, other_pose)]), *OPEN)

    def gap(k):
        moved = make_pose([*(moves[k]), 0.0], yaw)
        return separation(footprint(shape, moved), footprint(other, other_pose)).distance

    assert all(gap(k) > -1e-9 for k in range(count))
    if count < len(moves):
        # Polygons around circles stick out by half a percent.
        assert gap(count) < 0.0015


PLACES = st.lists(st.tuples(SHAPES, st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), ANGLES), max_size=5)


@QUICK
@given(PLACES, SHAPES, ANGLES, st.integers(0, 1000))
def test_many_overlaps_at_once(standing, shape, yaw, seed):
    """Boxes and cylinders mixed, all pairs or some, as one pair at a time."""
    rng = np.random.default_rng(seed)
    outlines = [footprint_corners(s, make_pose([x, y, 0.0], turn)) for s, x, y, turn in standing]
    corners = footprint_corners(shape, make_pose([0, 0, 0], yaw))
    moved = corners + rng.uniform(-0.5, 0.5, (12, 1, 2))
    pairs = np.array([[overlap(m, o) for o in outlines] for m in moved], dtype=bool)
    pairs = pairs.reshape(len(moved), len(outlines))
    obstacles = Outlines(outlines)
    assert np.array_equal(obstacles.overlapped(moved), pairs.any(axis=1))
    relevant = rng.random(pairs.shape) < 0.5
    assert np.array_equal(obstacles.overlapped(moved, relevant), (pairs & relevant).any(axis=1))


@QUICK
@given(SHAPES, SHAPES, ANGLES, ANGLES, st.floats(0.05, 0.4), ANGLES)
def test_overlap_is_no_distance(shape, other, yaw, other_yaw, distance, angle):
    pose, there = make_pose([0, 0, 0], yaw), make_pose([*(distance * unit(angle)), 0.0], other_yaw)
    gap = separation(footprint(shape, pose), footprint(other, there)).distance
    meet = overlap(footprint_corners(shape, pose), footprint_corners(other, there))
    # Polygons around circles stick out by half a percent.
    assert meet if gap < -1e-9 else (gap < 0.0015 or not meet)
