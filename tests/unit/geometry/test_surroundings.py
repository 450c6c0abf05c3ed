"""The arrays of a world hold every box and cylinder that counts, where it is."""

import numpy as np
import pytest
from mamo_geometry.options import SphereCheckerOptions
from mamo_geometry.recent import Recent
from mamo_geometry.sphere_checker import SphereChecker
from mamo_geometry.surroundings import Surroundings

from mamo_core.interfaces.collision_checker import HeldObject
from mamo_core.types.geometry import Box, make_pose, matrix_from_pose

MARGIN = 0.002


def primitives(scene, poses, ignore):
    """Transform and shape of everything in the world, one at a time."""
    standing = [(f, f.pose) for f in scene.fixtures] + list(zip(scene.objects, poses, strict=True))
    for item, pose in standing:
        if item.name not in ignore:
            yield matrix_from_pose(pose), item.shape


def scattered(scene, seed):
    rng = np.random.default_rng(seed)
    space = scene.workspace
    return np.array(
        [
            make_pose(rng.uniform(space.lower, space.upper), rng.uniform(-3, 3))
            for _ in scene.objects
        ]
    )


def names_of(scene):
    return [o.name for o in scene.objects], [f.name for f in scene.fixtures]


@pytest.mark.parametrize("seed", range(5))
def test_everything_is_there(shelf, arm, seed):
    scene, rng = shelf.scene, np.random.default_rng(seed)
    objects, fixtures = names_of(scene)
    surroundings = Surroundings(scene, arm)
    for ignore in (
        [],
        objects,
        [*objects, *fixtures],
        rng.choice([*objects, *fixtures], 6).tolist(),
    ):
        poses = scattered(scene, seed)
        world = surroundings.world(poses, ignore, MARGIN)
        expected = list(primitives(scene, poses, ignore))
        assert len(world.centre) == len(expected)
        assert world.margin == MARGIN
        for k, (T, shape) in enumerate(expected):
            np.testing.assert_allclose(world.centre[k], T[:3, 3], atol=1e-15)
            np.testing.assert_allclose(world.rotation[k], T[:3, :3], atol=1e-15)
            assert world.round[k] == (not isinstance(shape, Box))
            np.testing.assert_allclose(2.0 * world.half[k, 2], shape.height)
            spread = np.abs(T[:3, :3]) @ world.half[k]
            np.testing.assert_allclose(world.low[k], T[:3, 3] - spread, atol=1e-15)
            np.testing.assert_allclose(world.high[k], T[:3, 3] + spread, atol=1e-15)
        if expected:
            np.testing.assert_array_equal(world.lower, world.low.min(axis=0))
            np.testing.assert_array_equal(world.upper, world.high.max(axis=0))


def test_skipped_links_touch_nothing(shelf, arm, checker, kinematics):
    """Links before ``active_from`` are clear of everything they are checked for, however bent."""
    world = checker.world(shelf.initial.object_poses, opening=0.0)
    assert 0 <= world.world.active_from < arm.dof
    rng = np.random.default_rng(0)
    low, high = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    anywhere = rng.uniform(low, high, (2_000, arm.dof))
    complete = SphereChecker(shelf.scene, arm, SphereCheckerOptions())
    other = complete.world(shelf.initial.object_poses, opening=0.0)
    other.world = other.world._replace(active_from=0)
    np.testing.assert_array_equal(world.free(anywhere), other.free(anywhere))


def same(one, other):
    """Whether two worlds hold the same numbers."""
    pairs = [
        *zip(one.world, other.world, strict=True),
        *zip(one.spheres, other.spheres, strict=True),
    ]
    return all(np.array_equal(a, b) for a, b in pairs)


def test_what_was_asked_before_does_not_matter(shelf, arm, checker):
    """More states, margins and held objects than are kept, in some order, twice."""
    scene = shelf.scene
    objects, _ = names_of(scene)
    rng = np.random.default_rng(1)
    asked = []
    for seed in range(40):
        item = scene.objects[int(rng.integers(len(scene.objects)))]
        T = np.eye(4)
        T[:3, 3] = rng.uniform(-0.05, 0.05, 3)
        held = HeldObject(item.name, item.shape, T) if seed % 3 == 0 else None
        ignore = [item.name, *rng.choice(objects, 2)]
        asked.append((scattered(scene, seed % 20), ignore, held, float(rng.choice([0.0, 0.02]))))
    for n in [*range(40), *rng.permutation(40), *rng.permutation(40)]:
        poses, ignore, held, margin = asked[n]
        wanted = {"opening": 0.05, "ignore": ignore, "held": held, "margin": margin}
        fresh = SphereChecker(scene, arm, SphereCheckerOptions())
        assert same(checker.world(poses, **wanted), fresh.world(poses, **wanted))


def test_the_latest_are_kept():
    made = []
    recent = Recent(2)

    def value(key):
        return recent.get(key, lambda: made.append(key) or -key)

    assert [value(key) for key in (1, 2, 1, 3, 1, 2)] == [-1, -2, -1, -3, -1, -2]
    assert made == [1, 2, 3, 2]
