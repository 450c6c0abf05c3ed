import numpy as np
import pytest

from mamo_core.testing.gantry_arm import gantry_arm
from mamo_core.types.geometry import Box, Cylinder
from mamo_core.types.region import SweptRegion
from mamo_core.view.solids import part_mesh, region_mesh, shape_mesh


def region(lowest):
    return SweptRegion(np.array([1.0, 2.0]), 0.1, np.array(lowest), floor=0.5)


def test_shapes_have_their_extents():
    assert shape_mesh(Box(np.array([0.1, 0.2, 0.3]))).extents == pytest.approx([0.1, 0.2, 0.3])
    assert shape_mesh(Cylinder(0.1, 0.3)).extents == pytest.approx([0.2, 0.2, 0.3], rel=1e-2)


def test_links_have_the_surfaces_of_all_their_files():
    arm = gantry_arm()
    assert part_mesh(arm.links[0]) is None
    mesh = part_mesh(arm.links[3])
    assert len(mesh.faces) == 2 * 12
    assert mesh.bounds[1, 2] == pytest.approx(0.32)


def test_the_swept_space_is_closed_and_holds_what_its_cells_hold():
    """The volume of a surface with a hole, or turned inside out, would be another."""
    none = np.inf
    lowest = [[none, 0.8, 0.7], [0.4, 0.8, none], [none, 0.6, 0.95]]
    mesh = region_mesh(region(lowest), top=0.9)
    heights = 0.1 + 0.2 + 0.4 + 0.1 + 0.3  # one reaches below the floor, one is above the top
    assert mesh.volume == pytest.approx(0.01 * heights)
    assert mesh.bounds == pytest.approx(np.array([[1.0, 2.0, 0.5], [1.3, 2.3, 0.9]]))


def test_there_are_no_walls_inside_the_swept_space():
    mesh = region_mesh(region([[0.5, 0.5], [0.5, 0.5]]), top=0.9)
    assert mesh.area == pytest.approx(2 * 0.2**2 + 4 * 0.2 * 0.4)


def test_nothing_swept_is_nothing():
    assert region_mesh(region([[np.inf, 1.0]]), top=0.9) is None
