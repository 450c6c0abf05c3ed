"""How often a plan holds where the world is a little off."""

from dataclasses import replace

import numpy as np
import pytest

from mamo_core.margin import possible_poses, share_that_holds
from mamo_core.problems.footprints import footprint, separation
from mamo_core.testing.scenes import clear_scene
from mamo_core.types.deviation import Deviation
from mamo_core.types.scene import SceneState


def distances(problem, poses):
    """Between all pairs of objects, seen from above, m."""
    items = problem.scene.objects
    outlines = [footprint(i.shape, pose) for i, pose in zip(items, poses, strict=True)]
    return [separation(a, b).distance for n, a in enumerate(outlines) for b in outlines[n + 1 :]]


@pytest.fixture
def crowded():
    """The movable stands 2 mm beside the target."""
    problem = clear_scene().problem
    poses = np.array(problem.initial.object_poses)
    one, other = problem.scene.index("a"), problem.scene.target_index
    poses[one, :2] = poses[other, :2] + [0.0, 0.1]
    poses[one, 1] -= min(distances(problem, poses)) - 0.002
    return replace(problem, initial=SceneState(problem.initial.joint_positions, poses))


def test_possible_poses_overlap_nowhere(crowded):
    rng = np.random.default_rng(0)
    before = crowded.initial.object_poses
    assert min(distances(crowded, before)) == pytest.approx(0.002)
    found = [possible_poses(crowded, Deviation(0.01, 0.1), rng) for _ in range(40)]
    for poses in found:
        assert min(distances(crowded, poses)) >= 0.0
        assert np.linalg.norm((poses - before)[:, :2], axis=1).max() <= 0.01 * (1.0 + 1e-9)
    assert sum(not np.array_equal(poses, before) for poses in found) == 40


def test_a_plan_with_room_always_holds(problem, planner, plan):
    context = planner.context
    hair = Deviation(1e-6, 1e-6)
    assert share_that_holds(problem, plan, context.backend, context.robot, hair, 2) == 1.0


def test_one_that_misses_what_stands_elsewhere_does_not(problem, planner, plan):
    """Half a hand off, most of the time."""
    context = planner.context
    far = Deviation(0.06, 0.5)
    assert share_that_holds(problem, plan, context.backend, context.robot, far, 3) < 1.0
