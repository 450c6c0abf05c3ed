from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from mamo_core.problems.footprints import (
    Footprint,
    disc,
    extents,
    footprint,
    rectangle,
    separation,
)
from mamo_core.types.geometry import Box, Cylinder, make_pose


def random_footprint(rng: np.random.Generator) -> Footprint:
    x, y, yaw = rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2), rng.uniform(-4, 4)
    if rng.random() < 0.5:
        return disc(x, y, rng.uniform(0.03, 0.1))
    return rectangle(x, y, yaw, rng.uniform(0.03, 0.1), rng.uniform(0.03, 0.1))


def moved(one: Footprint, dx: float, dy: float) -> Footprint:
    return one._replace(x=one.x + dx, y=one.y + dy)


def outline(one: Footprint) -> np.ndarray:
    """Points (k, 2) on the edge."""
    t = np.linspace(0.0, 1.0, 200, endpoint=False)
    if one.round:
        a = 2 * np.pi * t
        return np.array([one.x, one.y]) + one.radius * np.stack([np.cos(a), np.sin(a)], axis=1)
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]]) * [one.hx, one.hy]
    edge = np.concatenate([a + t[:, None] * (b - a) for a, b in itertools.pairwise(corners)])
    R = np.array([[one.c, -one.s], [one.s, one.c]])
    return np.array([one.x, one.y]) + edge @ R.T


def test_known_distances() -> None:
    assert separation(disc(0, 0, 1), disc(3, 0, 1)) == (1.0, 1.0, 0.0)
    assert separation(rectangle(0, 0, 0, 1, 1), disc(4, 5, 1)).distance == pytest.approx(4.0)
    assert separation(rectangle(0, 0, 0, 1, 1), rectangle(3, 0, 0, 1, 1)) == (1.0, 1.0, 0.0)
    diagonal = separation(rectangle(0, 0, 0, 1, 1), rectangle(3, 3, math.pi / 4, 1, 1))
    assert diagonal.distance == pytest.approx(2 * math.sqrt(2) - 1)
    assert (diagonal.nx, diagonal.ny) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)))


def test_centres_inside_each_other_have_a_way_out() -> None:
    assert separation(disc(0, 0, 1), disc(0, 0, 1)).distance == -2.0
    assert separation(rectangle(0, 0, 0, 1, 2), disc(0.9, 0, 0.5)) == (-0.6, 1.0, 0.0)


def test_apart_agrees_with_points_on_the_outlines() -> None:
    rng = np.random.default_rng(0)
    for _ in range(60):
        a, b = random_footprint(rng), random_footprint(rng)
        found = separation(a, b)
        if found.distance <= 0.0:
            continue
        pa, pb = outline(a), outline(b)
        nearest = np.sqrt(((pa[:, None] - pb[None]) ** 2).sum(axis=2)).min()
        assert found.distance == pytest.approx(nearest, abs=2e-3)


def test_moving_by_the_depth_along_the_normal_just_parts_them() -> None:
    rng = np.random.default_rng(1)
    for _ in range(300):
        a, b = random_footprint(rng), random_footprint(rng)
        found = separation(a, b)
        assert math.hypot(found.nx, found.ny) == pytest.approx(1.0)
        apart = moved(b, -found.distance * found.nx, -found.distance * found.ny)
        assert separation(a, apart).distance == pytest.approx(0.0, abs=1e-9)


def test_swapping_flips_the_normal_only() -> None:
    rng = np.random.default_rng(2)
    for _ in range(100):
        a, b = random_footprint(rng), random_footprint(rng)
        there, back = separation(a, b), separation(b, a)
        assert there.distance == pytest.approx(back.distance, abs=1e-12)


def test_footprint_of_shapes() -> None:
    pose = make_pose([1.0, 2.0, 0.8], np.pi / 2)
    assert extents(footprint(Box(np.array([0.2, 0.4, 1.0])), pose)) == pytest.approx(
        (0.8, 1.9, 1.2, 2.1)
    )
    assert extents(footprint(Cylinder(0.1, 1.0), pose)) == pytest.approx((0.9, 1.9, 1.1, 2.1))
