"""Where the camera stands, by projecting what it must see."""

from itertools import product
from pathlib import Path

import numpy as np
import pytest

from mamo_core.problems import load_problem
from mamo_core.view.shots import shot_of

PROBLEMS = Path(__file__).parents[3] / "problems"
SCENES = ("shelf_10_medium_seed1", "panda_open_shelf", "tabletop_6_6_seed1")


def seen(shot, points):
    """Picture coordinates (k, 2) of points (k, 3): -1 to 1 from edge to edge."""
    forward = (shot.target - shot.eye) / np.linalg.norm(shot.target - shot.eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    slope = np.tan(shot.view_angle / 2.0)
    relative = points - shot.eye
    depth = relative @ forward
    assert (depth > 0.0).all()
    across = relative @ right / depth / slope * shot.height / shot.width
    return np.stack([across, relative @ up / depth / slope], axis=1)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("size", [(640, 480), (300, 600)])
def test_every_object_is_in_the_picture_and_fills_it(name, size):
    problem = load_problem(str(PROBLEMS / f"{name}.yaml"))
    shot = shot_of(problem, *size)
    objects = seen(shot, problem.initial.object_poses[:, :3])
    assert (np.abs(objects) < 1.0).all()
    space = problem.scene.workspace
    corners = np.array(list(product(*zip(space.lower, space.upper, strict=True))))
    assert np.abs(seen(shot, corners)).max() > 0.6


def test_only_what_hides_the_shelf_is_outlined():
    shelf = load_problem(str(PROBLEMS / "shelf_10_medium_seed1.yaml"))
    assert shot_of(shelf, 640, 480).outlined == {"top"}
    table = load_problem(str(PROBLEMS / "tabletop_6_6_seed1.yaml"))
    assert shot_of(table, 640, 480).outlined == frozenset()
