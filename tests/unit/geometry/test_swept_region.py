"""Swept regions leave nothing out, and overlap what they say they overlap."""

import numpy as np
import pytest
import trimesh

from mamo_core.interfaces.collision_checker import HeldObject
from mamo_core.robots.kinematics import link_transforms
from mamo_core.robots.timing import interpolated
from mamo_core.types.geometry import (
    Box,
    Cylinder,
    footprint_corners,
    make_pose,
    matrix_from_pose,
    yaw_of,
)
from mamo_core.types.region import SweptRegion

OPENING = 0.085


@pytest.fixture(scope="module")
def path(kinematics):
    """Straight into the shelf."""
    T = np.eye(4)
    T[:3, 3] = 0.45, -0.5, 0.87
    rng = np.random.default_rng(0)
    T_end = T.copy()
    T_end[0, 3] = 0.75
    lines = [kinematics.follow_line(q, T_end) for q in kinematics.inverse(T, rng, count=4)]
    return max(lines, key=lambda line: line.fraction).path


def heights_under(region, points):
    """``lowest`` of the cells of points (k, 3), and which of them are over the region."""
    cells = np.floor((points[:, :2] - region.origin) / region.resolution).astype(int)
    inside = ((cells >= 0) & (cells < region.lowest.shape)).all(axis=1)
    return region.lowest[tuple(cells[inside].T)], inside


def arm_vertices(arm, T_world_base, q):
    transforms = link_transforms(arm, q, OPENING)
    parts = []
    for link, T in zip(arm.links, transforms, strict=True):
        for file in link.meshes:
            vertices = MESHES.setdefault(file, trimesh.load(file, force="mesh").vertices)
            parts.append(vertices @ (T_world_base @ T)[:3, :3].T + (T_world_base @ T)[:3, 3])
    return np.vstack(parts)


MESHES: dict = {}


def test_no_part_of_the_arm_is_below_the_region(arm, shelf, checker, path):
    region = checker.swept_region(path, opening=OPENING)
    T_world_base = matrix_from_pose(shelf.scene.T_world_base)
    seen = 0
    # Not the configurations that the kernel looks at.
    for q in interpolated(path, 0.011)[::2]:
        points = arm_vertices(arm, T_world_base, q)
        lowest, inside = heights_under(region, points)
        seen += inside.sum()
        assert (points[inside, 2] >= lowest - 1e-9).all()
    assert seen > 10_000


def test_it_is_not_much_too_low(arm, shelf, checker, path):
    """No lower than spheres stick out of the links that come over the shelf."""
    region = checker.swept_region(path, opening=OPENING)
    T_world_base = matrix_from_pose(shelf.scene.T_world_base)
    lowest = np.inf
    for q in interpolated(path, 0.05):
        points = arm_vertices(arm, T_world_base, q)
        _, inside = heights_under(region, points)
        lowest = min(lowest, points[inside, 2].min(initial=np.inf))
    assert lowest - 0.06 < region.lowest.min() < lowest


def test_the_held_object_is_part_of_it(shelf, checker, kinematics, path):
    shape = Cylinder(0.04, 0.2)
    T_tool_object = np.eye(4)
    T_tool_object[2, 3] = -0.02
    held = HeldObject("held", shape, T_tool_object)
    bare = checker.swept_region(path, opening=OPENING)
    loaded = checker.swept_region(path, opening=OPENING, held=held)
    assert (loaded.lowest <= bare.lowest).all()
    rng = np.random.default_rng(1)
    angles = rng.uniform(0, 2 * np.pi, 400)
    side = np.column_stack(
        [0.04 * np.cos(angles), 0.04 * np.sin(angles), rng.uniform(-0.1, 0.1, 400)]
    )
    for q in interpolated(path, 0.013):
        T = kinematics.forward(q) @ T_tool_object
        points = side @ T[:3, :3].T + T[:3, 3]
        lowest, inside = heights_under(loaded, points)
        assert inside.all()
        assert (points[inside, 2] >= lowest - 1e-6).all()
    changed = loaded.lowest < bare.lowest
    bottom = (kinematics.forward(path[-1]) @ T_tool_object)[2, 3] - 0.1
    assert loaded.lowest[changed].min() == pytest.approx(bottom, abs=1e-3)


def test_nothing_passes_where_the_arm_does_not(checker, path):
    region = checker.swept_region(path, opening=OPENING)
    assert np.isinf(region.lowest).sum() > 0.3 * region.lowest.size
    far = make_pose([0.95, -0.85, region.floor + 0.1])
    assert not region.overlaps(Box(np.array([0.06, 0.06, 0.2])), far)


def random_body(rng, region):
    box = rng.random() < 0.5
    size = rng.uniform(0.04, 0.12, 3)
    shape = Box(size) if box else Cylinder(size[0] / 2, size[2])
    x, y = region.origin + rng.uniform(0.1, 0.9, 2) * region.lowest.shape * region.resolution
    return shape, make_pose([x, y, region.floor + shape.height / 2.0], rng.uniform(-3, 3))


def covers(shape, pose, points):
    """Which points (k, 2) are under the standing shape."""
    d = points - pose[:2]
    if isinstance(shape, Cylinder):
        return np.hypot(*d.T) <= shape.radius
    c, s = np.cos(yaw_of(pose)), np.sin(yaw_of(pose))
    u, v = c * d[:, 0] + s * d[:, 1], -s * d[:, 0] + c * d[:, 1]
    return (np.abs(u) <= shape.size[0] / 2) & (np.abs(v) <= shape.size[1] / 2)


def patchy_region(seed, floor=0.7):
    rng = np.random.default_rng(seed)
    lowest = np.where(rng.random((12, 15)) < 0.15, floor + rng.uniform(0, 0.2, (12, 15)), np.inf)
    return SweptRegion(np.array([0.2, -0.4]), 0.04, lowest, floor)


@pytest.mark.parametrize("seed", range(4))
def test_overlap_agrees_with_brute_force(seed):
    """Every sampled hit is reported; and nothing further away than half a diagonal is."""
    region = patchy_region(seed)
    rng = np.random.default_rng(seed)
    nx, ny = region.lowest.shape
    n = 10  # samples along the side of a cell
    axes = [
        region.origin[k] + (np.arange(m * n) + 0.5) * region.resolution / n
        for k, m in enumerate((nx, ny))
    ]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    fine = np.repeat(np.repeat(region.lowest, n, axis=0), n, axis=1)
    hits = misses = 0
    for _ in range(60):
        shape, pose = random_body(rng, region)
        under = covers(shape, pose, grid.reshape(-1, 2)).reshape(nx * n, ny * n)
        brute = under & (fine < pose[2] + shape.height / 2.0)
        if brute.any():
            hits += 1
            assert region.overlaps(shape, pose)
            assert region.overlap(shape, pose) >= brute.sum() * (region.resolution / n) ** 2
        wide = region.resolution * np.sqrt(0.5) * 2 + 0.002
        grown = (
            Cylinder(shape.radius + wide, shape.height)
            if isinstance(shape, Cylinder)
            else Box(shape.size + np.array([2 * wide, 2 * wide, 0.0]))
        )
        near = covers(grown, pose, grid.reshape(-1, 2)).reshape(nx * n, ny * n)
        if not (near & (fine < pose[2] + shape.height / 2.0)).any():
            misses += 1
            assert not region.overlaps(shape, pose)
    assert hits > 10
    assert misses > 3


def test_a_sweep_over_the_top_is_no_overlap():
    region = SweptRegion(np.zeros(2), 0.1, np.full((4, 4), 1.0), 0.7)
    shape = Cylinder(0.03, 0.2)
    low, high = make_pose([0.2, 0.2, 0.8]), make_pose([0.2, 0.2, 0.95])
    assert not region.overlaps(shape, low)
    assert region.overlaps(shape, high)
    assert region.overlap(shape, high) >= np.pi * 0.03**2


def test_touched_cells_hold_the_whole_outline():
    region = patchy_region(0)
    rng = np.random.default_rng(3)
    for _ in range(50):
        shape, pose = random_body(rng, region)
        for corner in footprint_corners(shape, pose):
            reach = shape.footprint_radius / np.hypot(*(corner - pose[:2]))
            point = pose[:2] + (corner - pose[:2]) * min(1.0, reach) * 0.999
            cell = np.floor((point - region.origin) / region.resolution).astype(int)
            if ((cell >= 0) & (cell < region.lowest.shape)).all():
                assert region.touched_cells(shape, pose)[tuple(cell)]


def test_only_cells_near_the_footprint_are_touched():
    """Wherever the body stands, and also outside of the region: every cell by its distance."""
    region = patchy_region(4)
    rng = np.random.default_rng(5)
    nx, ny = region.lowest.shape
    cells = np.stack(np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij"), axis=-1)
    centres = region.origin + (cells + 0.5) * region.resolution
    size = np.array([nx, ny]) * region.resolution
    reach = region.resolution * np.sqrt(0.5)
    for _ in range(100):
        shape, pose = random_body(rng, region)
        pose = make_pose(
            [*(region.origin + rng.uniform(-0.3, 1.3, 2) * size), pose[2]], yaw_of(pose)
        )
        c, s = np.cos(yaw_of(pose)), np.sin(yaw_of(pose))
        local = np.abs((centres - pose[:2]) @ np.array([[c, -s], [s, c]]))
        if isinstance(shape, Cylinder):
            distance = np.linalg.norm(local, axis=-1) - shape.radius
        else:
            distance = np.linalg.norm(np.maximum(local - shape.size[:2] / 2.0, 0.0), axis=-1)
        touched = region.touched_cells(shape, pose)
        certain = np.abs(distance - reach) > 1e-9
        assert np.array_equal(touched[certain], (distance <= reach)[certain])
        hit = touched & (region.lowest < pose[2] + shape.height / 2.0)
        assert region.overlap(shape, pose) == hit.sum() * region.resolution**2


def test_united_is_either():
    one, other = patchy_region(1), patchy_region(2)
    both = one.united(other)
    assert np.array_equal(both.lowest, np.minimum(one.lowest, other.lowest))
    rng = np.random.default_rng(0)
    for _ in range(40):
        shape, pose = random_body(rng, both)
        either = one.overlaps(shape, pose) or other.overlaps(shape, pose)
        assert both.overlaps(shape, pose) == either


def test_the_region_of_two_stretches_is_united(checker, path):
    whole = checker.swept_region(path, opening=OPENING)
    half = len(path) // 2
    parts = [checker.swept_region(p, opening=OPENING) for p in (path[: half + 1], path[half:])]
    np.testing.assert_allclose(parts[0].united(parts[1]).lowest, whole.lowest, atol=1e-12)


def test_reversed_it_sweeps_the_same(checker, path):
    there, back = (checker.swept_region(p, opening=OPENING) for p in (path, path[::-1]))
    finite = np.isfinite(there.lowest) & np.isfinite(back.lowest)
    np.testing.assert_allclose(there.lowest[finite], back.lowest[finite], atol=1e-3)
    assert (np.isfinite(there.lowest) == np.isfinite(back.lowest)).all()
