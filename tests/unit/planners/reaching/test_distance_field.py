"""Distances of the tool around obstacles: known ones, and against Dijkstra of SciPy."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mamo_planners.reaching.distance_field import DistanceField, spread
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from mamo_core.types.geometry import Box, Cylinder, make_pose

LOWER, UPPER = np.zeros(3), np.array([1.0, 1.0, 0.4])
CHAMFER = np.array([10, 14, 17])
NEVER = np.iinfo(np.int64).max


def field_from(source, *solids, growth=0.0, resolution=0.1):
    field = DistanceField(LOWER, UPPER, resolution, solids, growth)
    field.spread_from(np.atleast_2d(np.array(source, dtype=float)))
    return field


def wall(thickness=0.1, y=0.4, length=0.9):
    """Across the box at x = 0.5, open beyond y = 0.85."""
    return Box(np.array([thickness, length, 2.0])), make_pose([0.5, y, 0.0])


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ((0.0, 0.0, 0.0), 0.0),
        ((0.5, 0.0, 0.0), 0.5),
        ((0.3, 0.3, 0.0), 3 * 0.14),
        ((0.2, 0.2, 0.2), 2 * 0.17),
        ((0.4, 0.3, 0.1), 0.17 + 2 * 0.14 + 0.1),
        ((0.52, 0.0, 0.0), 0.5),  # of the cell
    ],
)
def test_nothing_in_the_way(point, expected):
    assert field_from([0, 0, 0]).distance(np.array(point)) == pytest.approx(expected)


def test_beyond_the_box_it_is_as_far_as_at_its_border():
    field = field_from([0, 0, 0])
    assert field.distance(np.array([3.0, 0.0, -1.0])) == pytest.approx(1.0)


def test_the_nearest_of_several_sources():
    field = field_from([[0, 0, 0], [1, 0, 0]])
    assert field.distance(np.array([0.8, 0, 0])) == pytest.approx(0.2)


def test_around_a_wall():
    field = field_from([0.4, 0.0, 0.0], wall())
    across = field.distance(np.array([0.6, 0.0, 0.0]))
    # To y = 0.8, diagonally past the wall's last cell, and back.
    assert across == pytest.approx(2 * (0.8 + 0.14))
    assert field.distance(np.array([0.5, 0.3, 0.0])) == math.inf


def test_growth_closes_the_gap():
    beyond = np.array([0.8, 0.0, 0.0])
    assert math.isfinite(field_from([0, 0, 0], wall(), growth=0.1).distance(beyond))
    assert field_from([0, 0, 0], wall(), growth=0.2).distance(beyond) == math.inf


def test_growth_in_metres():
    post = Cylinder(0.05, 2.0), make_pose([0.5, 0.5, 0.0])
    inside = np.array([0.6, 0.5, 0.0])
    assert math.isfinite(field_from([0, 0, 0], post, growth=0.04).distance(inside))
    assert field_from([0, 0, 0], post, growth=0.06).distance(inside) == math.inf


def test_a_cylinder_is_round_and_a_box_is_turned():
    corner = np.array([0.7, 0.7, 0.0])
    cylinder = Cylinder(0.25, 2.0), make_pose([0.5, 0.5, 0.0])
    straight = Box(np.array([0.5, 0.5, 2.0])), make_pose([0.5, 0.5, 0.0])
    turned = straight[0], make_pose([0.5, 0.5, 0.0], np.pi / 4)
    blocked = [field_from([0, 0, 0], solid).distance(corner) for solid in (cylinder, turned)]
    assert all(math.isfinite(way) for way in blocked)
    assert field_from([0, 0, 0], straight).distance(corner) == math.inf
    assert field_from([0, 0, 0], turned).distance(np.array([0.8, 0.5, 0.0])) == math.inf


def test_below_a_shape_there_is_a_way():
    low = Box(np.array([0.1, 3.0, 0.2])), make_pose([0.5, 0.5, 0.3])
    assert field_from([0, 0, 0], low).distance(np.array([1.0, 0, 0])) == pytest.approx(1.0)


def test_a_source_inside_a_blocked_cell_leads_out():
    thick = wall(thickness=0.5, length=3.0)
    field = field_from([0.4, 0.5, 0.0], thick)
    assert field.distance(np.array([0.0, 0.5, 0.0])) == pytest.approx(0.4)
    # Out on the other side, too, but from neither side back in.
    assert field.distance(np.array([1.0, 0.5, 0.0])) == pytest.approx(0.6)


def test_no_way_through_what_is_shut():
    assert field_from([0, 0, 0], wall(length=3.0)).distance(np.array([1.0, 0, 0])) == math.inf


def by_dijkstra(blocked, sources):
    """Every step costs its kind; none leads from a free cell into a blocked one."""
    cells = np.argwhere(np.ones_like(blocked))
    away = np.abs(cells[:, None] - cells[None]).max(axis=2)
    kinds = np.abs(cells[:, None] - cells[None]).sum(axis=2)
    flat = blocked.reshape(-1)
    allowed = (away == 1) & (flat[:, None] | ~flat[None, :])
    costs = np.where(allowed, CHAMFER[np.clip(kinds, 1, 3) - 1], 0)
    numbers = np.ravel_multi_index(sources.T, blocked.shape)
    return dijkstra(csr_array(costs), indices=numbers, min_only=True).reshape(blocked.shape)


@settings(max_examples=60)
@given(data=st.data())
def test_as_dijkstra_finds_it(data):
    shape = tuple(data.draw(st.tuples(*[st.integers(1, 5)] * 3)))
    share = data.draw(st.floats(0.0, 0.9))
    rng = np.random.default_rng(data.draw(st.integers(0, 10**6)))
    blocked = rng.random(shape) < share
    sources = np.array([[rng.integers(n) for n in shape] for _ in range(rng.integers(1, 4))])
    costs = np.full(shape, NEVER)
    spread(blocked, sources, CHAMFER, costs)
    found = np.where(costs == NEVER, np.inf, costs.astype(float))
    assert np.array_equal(found, by_dijkstra(blocked, sources))
