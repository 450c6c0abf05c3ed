"""Places for an object on the shelf: free, outside the region, nearest first."""

import numpy as np
import pytest
from mamo_planners.actions.placement import FreeSpots, moved_to, turned

from mamo_core.problems import generate_shelf
from mamo_core.problems.footprints import footprint, separation
from mamo_core.types.geometry import make_pose, yaw_of
from mamo_core.types.region import SweptRegion

MARGIN = 0.01
SMALL = [3, 5, 6, 10, 14]


@pytest.fixture(scope="module")
def scene_and_poses():
    problem = generate_shelf(movables=10, seed=1)
    return problem.scene, problem.initial.object_poses


def region_of(scene, blocked):
    """Swept to the floor where ``blocked(x, y)``."""
    lower, upper = scene.workspace.lower[:2], scene.workspace.upper[:2]
    cells = [np.arange(a, b, 0.01) for a, b in zip(lower, upper, strict=True)]
    x, y = np.meshgrid(*cells, indexing="ij")
    lowest = np.where(blocked(x, y), scene.workspace.floor, np.inf)
    return SweptRegion(lower, 0.01, lowest, scene.workspace.floor)


@pytest.mark.parametrize("number", SMALL)
def test_drawn_places_are_free_and_clear(scene_and_poses, number):
    scene, poses = scene_and_poses
    middle = (scene.workspace.lower[1] + scene.workspace.upper[1]) / 2.0
    region = region_of(scene, lambda x, y: y > middle)
    spots = FreeSpots(scene, poses, number, MARGIN)
    found = spots.draw(region, np.random.default_rng(number), 1_000, 24)
    assert found
    shape = scene.objects[number].shape
    for pose in moved_to(poses[number], found):
        assert not region.overlaps(shape, pose)
        for i, item in enumerate(scene.objects):
            if i != number:
                gap = separation(footprint(shape, pose), footprint(item.shape, poses[i])).distance
                assert gap > MARGIN - 1e-9
    distances = np.linalg.norm(np.array(found) - poses[number][:2], axis=1)
    assert (np.diff(distances) >= 0.0).all()


def test_free_draws_are_taken_in_their_order(scene_and_poses):
    """Asked for fewer, it gives the first ones of those that it gives when asked for more."""
    scene, poses = scene_and_poses
    region = region_of(scene, lambda x, y: np.zeros_like(x, dtype=bool))
    spots = FreeSpots(scene, poses, SMALL[0], MARGIN)
    few = spots.draw(region, np.random.default_rng(0), 300, 5)
    many = spots.draw(region, np.random.default_rng(0), 300, 50)
    assert len(few) == 5
    assert {tuple(xy) for xy in few} < {tuple(xy) for xy in many}


def test_moving_and_turning():
    pose = make_pose([0.3, -0.2, 0.8], 0.4)
    again = turned(pose, 0.5)
    np.testing.assert_allclose(again[:3], pose[:3])
    assert yaw_of(again) == pytest.approx(0.9)
    moved = moved_to(again, [[0.1, 0.2], [0.5, 0.6]])
    np.testing.assert_array_equal(moved[:, :2], [[0.1, 0.2], [0.5, 0.6]])
    np.testing.assert_array_equal(moved[:, 2:], np.tile(again[2:], (2, 1)))
    assert moved_to(pose, []).shape == (0, 7)
