"""The kernel's spheres cover the arm, and every level of the hierarchy covers the next."""

from itertools import pairwise

import numpy as np
import pytest
import trimesh
from mamo_geometry.arrays import ArmSpheres, held_cover, shape_spheres, with_held

from mamo_core.robots import load_arm
from mamo_core.robots.kinematics import finger_transforms
from mamo_core.types.geometry import Box, Cylinder

ARMS = ["panda", "pr2_right_arm"]


def uncovered(points, spheres):
    gaps = np.linalg.norm(points[:, None] - spheres[None, :, :3], axis=2)
    return (gaps > spheres[:, 3] + 1e-6).all(axis=1)


def of_link(arrays, link):
    """The spheres (k, 4) of a moving link."""
    first, last = arrays.cluster_start[arrays.link_start[[link, link + 1]]]
    return arrays.spheres[first:last]


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("opening", [0.005, 0.07])
def test_hulls_are_covered_fingers_included(name, opening):
    arm = load_arm(name)
    arrays = ArmSpheres(arm).at(opening)
    fingers = finger_transforms(arm.links, arm.gripper.drive(opening))
    carrier = arm.links[arm.tool_link].coordinate
    for number, link in enumerate(arm.links):
        T = fingers.get(number, np.eye(4))
        spheres = of_link(arrays, carrier if number in fingers else link.coordinate)
        for file in link.hulls:
            hull = trimesh.load(file, force="mesh")
            points, _ = trimesh.sample.sample_surface(hull, 500, seed=1)
            points = points @ T[:3, :3].T + T[:3, 3]
            assert not uncovered(points, spheres).any(), link.name


def bounds(outer, inner):
    reach = np.linalg.norm(inner[:, :3] - outer[:3], axis=1) + inner[:, 3]
    return (reach <= outer[3] + 1e-9).all()


def check_levels(arrays):
    assert arrays.cluster_start[-1] == len(arrays.spheres)
    assert arrays.link_start[-1] == len(arrays.clusters)
    for c, (first, last) in enumerate(pairwise(arrays.cluster_start)):
        assert last > first
        assert bounds(arrays.clusters[c], arrays.spheres[first:last])
    for i, (first, last) in enumerate(pairwise(arrays.link_start)):
        if last > first:
            assert bounds(arrays.links[i], of_link(arrays, i))


@pytest.mark.parametrize("name", ARMS)
def test_every_level_covers_the_next(name):
    check_levels(ArmSpheres(load_arm(name)).at(0.03))


SHAPES = [Box(np.array([0.06, 0.11, 0.2])), Cylinder(0.04, 0.16), Box(np.array([0.06, 0.06, 0.06]))]


@pytest.mark.parametrize("shape", SHAPES, ids=["box", "cylinder", "cube"])
def test_sides_of_held_shapes_are_covered(shape):
    """All but a rim of 5 mm at the top and bottom edges, where spheres end flush."""
    mesh = (
        trimesh.creation.box(shape.size)
        if isinstance(shape, Box)
        else trimesh.creation.cylinder(shape.radius, shape.height, sections=64)
    )
    points, faces = trimesh.sample.sample_surface(mesh, 4_000, seed=2)
    side = np.abs(mesh.face_normals[faces][:, 2]) < 0.5
    away = np.abs(points[:, 2]) < shape.height / 2.0 - 0.005
    spheres = shape_spheres(shape, 0.012)
    assert (side & away).sum() > 1_000
    assert not uncovered(points[side & away], spheres).any()
    # Flush with top and bottom, bulging a little sideways.
    assert np.abs(spheres[:, 2]).max() + spheres[0, 3] == pytest.approx(shape.height / 2.0)
    if isinstance(shape, Box):
        reach = (np.abs(spheres[:, :2]) + spheres[:, 3:] - shape.size[:2] / 2.0).max()
    else:
        reach = (np.hypot(*spheres[:, :2].T) + spheres[:, 3]).max() - shape.radius
    assert 0.0 < reach < 0.015


def test_a_held_object_is_added_to_the_hand():
    arm = load_arm("pr2_right_arm")
    bare = ArmSpheres(arm).at(0.07)
    T = np.eye(4)
    T[:3, 3] = 0.2, 0.0, -0.03
    cover = held_cover(SHAPES[1])
    loaded = with_held(bare, cover, T, bare.up, np.radians(18.0))
    check_levels(loaded)
    assert loaded.min_up == pytest.approx(np.cos(np.radians(18.0)))
    assert bare.min_up == -1.0
    for link in range(arm.dof - 1):
        assert np.array_equal(of_link(loaded, link), of_link(bare, link))
    last = of_link(loaded, arm.dof - 1)
    expected = cover.spheres + np.array([0.2, 0.0, -0.03, 0.0])
    assert len(last) == len(of_link(bare, arm.dof - 1)) + len(expected)
    for sphere in expected:
        assert np.abs(last - sphere).max(axis=1).min() < 1e-12
