"""Footprints, pair tables and maps against geometry computed another way."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mamo_planners.mapf.convex import difference, hull, signed_distance
from mamo_planners.mapf.distance import FAR, uniform_distance, weighted_distance
from mamo_planners.mapf.footprint import footprint_of, pack
from mamo_planners.mapf.model import UNIT, Model
from mamo_planners.mapf.tables import APART, CLOSEST, build_pair_tables, overlap

from mamo_core.types.geometry import (
    Array,
    Box,
    Cylinder,
    Shape,
    frozen_array,
    make_pose,
    rotation_from_quat,
)
from mamo_core.types.mapf import GoalPenalty, MAPFAgent, MAPFObstacle, MAPFProblem
from mamo_core.types.region import SweptRegion
from mamo_core.verify_mapf import _gap, _outline, _wider

STEP = 0.01
sizes = st.floats(0.02, 0.12)
shapes = st.one_of(
    st.builds(lambda x, y: Box(np.array([x, y, 0.1])), sizes, sizes),
    st.builds(lambda r: Cylinder(r, 0.1), st.floats(0.01, 0.06)),
)
angles = st.floats(-7.0, 7.0)
tilts = st.sampled_from([0.0, 0.0, 0.01, 0.2, 1.2])


def tilted(position: Array, yaw: float, tilt: float) -> Array:
    """A pose turned about z and then leaning about the body's x axis."""
    c, s = np.cos(yaw / 2.0), np.sin(yaw / 2.0)
    a, b = np.cos(tilt / 2.0), np.sin(tilt / 2.0)
    return frozen_array([*position, c * a, c * b, s * b, s * a], "pose", (7,))


def surface(shape: Shape, pose: Array) -> Array:
    """Points (n, 3) of the body's rim or corners in the world."""
    half = shape.height / 2.0
    if isinstance(shape, Box):
        local = np.stack(np.meshgrid(*([[-0.5, 0.5]] * 3)), axis=-1).reshape(-1, 3) * shape.size
    else:
        angle = np.linspace(0.0, 2.0 * np.pi, 40)
        ring = shape.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        local = np.concatenate([np.c_[ring, np.full(40, z)] for z in (-half, half)])
    return local @ rotation_from_quat(pose[3:]).T + pose[:3]


@settings(max_examples=100, deadline=None)
@given(shapes, angles, tilts)
def test_a_footprint_holds_the_whole_body_and_its_upright_outline(
    shape: Shape, yaw: float, tilt: float
) -> None:
    pose = tilted(np.array([0.3, -0.2, 0.5]), yaw, tilt)
    footprint = footprint_of(shape, pose)
    outline = hull(footprint.points, len(footprint.points))
    upright = surface(shape, make_pose(pose[:3], yaw))
    for x, y, z in np.concatenate([surface(shape, pose), upright]):
        assert signed_distance(x - 0.3, y + 0.2, outline) <= footprint.radius + 1e-9
        assert footprint.bottom - 1e-9 <= z <= footprint.top + 1e-9


@settings(max_examples=40, deadline=None)
@given(shapes, shapes, angles, angles, tilts, st.sampled_from([0.0, 0.005]), st.randoms())
def test_pair_tables_hold_the_offsets_that_are_too_close(
    first: Shape, second: Shape, yaw: float, other_yaw: float, tilt: float, margin: float, random
) -> None:
    a = make_pose([random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), 0.05], yaw)
    b = tilted(np.array([0.0, 0.0, 0.05]), other_yaw, tilt)
    assume(np.hypot(a[0], a[1]) > STEP / 2)  # two bodies never stand in the very same place
    packed = pack([footprint_of(first, a), footprint_of(second, b)], [a[:2], b[:2]])
    tables = build_pair_tables(packed, STEP, margin)
    low, high, row, touching = tables
    here, there = _outline(first, a), _outline(second, b)
    start = _gap(here, a[:2], there, b[:2])
    assert touching[0, 1] == touching[1, 0]
    if abs(start - margin) > 1e-6:
        assert touching[0, 1] == (start < margin)
    for _ in range(30):
        dx, dy = random.randint(-25, 25), random.randint(-25, 25)
        gap = _gap(here, a[:2] + np.array([dx, dy]) * STEP, there, b[:2])
        for table, least in ((CLOSEST, min(margin, start)), (APART, margin)):
            if abs(gap - least) < 1e-6:
                continue
            found = overlap(low, high, row, table, 0, 1, dx, dy)
            assert found == (gap < least)
            assert overlap(low, high, row, table, 1, 0, -dx, -dy) == found


def test_bodies_at_different_heights_never_overlap() -> None:
    cube = Box(np.array([0.05, 0.05, 0.05]))
    poses = [make_pose([0.0, 0.0, 0.025]), make_pose([0.02, 0.0, 0.075])]
    packed = pack([footprint_of(cube, p) for p in poses], [p[:2] for p in poses])
    low, high, row, touching = build_pair_tables(packed, STEP, 0.005)
    assert not touching.any()
    assert not overlap(low, high, row, CLOSEST, 0, 1, 0, 0)


def test_hulls_of_degenerate_points() -> None:
    assert len(hull(np.zeros((3, 2)), 3)) <= 2
    line = np.array([[0.0, 0.0], [1.0, 1.0], [0.5, 0.5]])
    assert len(hull(line, 3)) == 2
    assert signed_distance(1.0, 0.0, hull(line, 3)) == pytest.approx(np.sqrt(0.5))
    point = difference(np.zeros((1, 2)), 1, np.zeros((1, 2)), 1)
    assert signed_distance(0.3, 0.4, point) == pytest.approx(0.5)


def random_model(rng: np.random.Generator) -> Model:
    """One body among obstacles, with a blotchy region, penalties and a goal margin."""
    shape: Shape = Cylinder(float(rng.uniform(0.02, 0.05)), 0.1)
    if rng.random() < 0.6:
        shape = Box(np.array([*rng.uniform(0.02, 0.1, 2), 0.1]))
    pose = make_pose([*rng.uniform(0.1, 0.3, 2), 0.05], rng.uniform(0, 6.3))
    obstacles = tuple(
        MAPFObstacle(
            f"w{k}",
            Cylinder(0.03, 0.1) if k == 0 else Box(np.array([0.05, 0.09, 0.1])),
            make_pose([*rng.uniform(0.0, 0.4, 2), 0.05], rng.uniform(0, 6.3)),
        )
        for k in range(2)
    )
    resolution = float(rng.choice([0.005, 0.01, 0.013]))
    cells = int(0.4 / resolution)
    lowest = np.where(rng.random((cells, cells)) < 0.01, 0.02, np.inf)
    lowest[: cells // 2, cells // 4 : cells // 3] = rng.choice([0.02, 0.2])
    penalties = (
        GoalPenalty(rng.uniform(0.0, 0.4, 2), 0.05, 2.5),
        GoalPenalty(rng.uniform(0.0, 0.4, 2), 0.05, float("inf")),
    )
    return Model(
        MAPFProblem(
            agents=(MAPFAgent("a", shape, pose, penalties),),
            obstacles=obstacles,
            region=SweptRegion(np.array([0.013, 0.0]), resolution, lowest, 0.0),
            transit_lower=np.zeros(2),
            transit_upper=np.full(2, 0.4),
            goal_lower=np.array([0.05, 0.0]),
            goal_upper=np.full(2, 0.4),
            margin=float(rng.choice([0.0, 0.004])),
            goal_margin=float(rng.choice([0.0, 0.01])),
        )
    )


@pytest.mark.parametrize("seed", range(8))
def test_maps_of_one_agent_agree_with_the_rules(seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = random_model(rng)
    problem = model.problem
    agent = problem.agents[0]
    grid = model.map(0)
    outline = _outline(agent.shape, agent.pose)
    low = outline.corners.min(axis=0) - outline.radius
    high = outline.corners.max(axis=0) + outline.radius
    blockers = [(_outline(o.shape, o.pose), o.pose[:2]) for o in problem.obstacles]
    starts = [_gap(outline, agent.pose[:2], other, at) for other, at in blockers]
    for i, j in rng.integers(0, grid.free.shape, (300, 2)):
        xy = agent.pose[:2] + (grid.first + np.array([i, j])) * STEP
        gaps = [_gap(outline, xy, other, at) for other, at in blockers]
        spare = [g - min(problem.margin, s) for g, s in zip(gaps, starts, strict=True)]
        if min(np.abs(spare)) < 1e-6:
            continue
        free = min(spare) > 0.0
        assert grid.free[i, j] == free
        pose = np.concatenate([xy, agent.pose[2:]])
        wide = _wider(agent.shape, problem.goal_margin)
        goal = free and not problem.region.overlaps(wide, pose)
        goal = goal and bool((xy + low >= problem.goal_lower - 1e-9).all())
        goal = goal and bool((xy + high <= problem.goal_upper + 1e-9).all())
        near = [p for p in agent.penalties if np.hypot(*(xy - p.position)) <= p.radius]
        cost = sum(p.cost for p in near)
        assert grid.goal[i, j] == (cost * UNIT if goal and np.isfinite(cost) else FAR)
    start_inside = problem.region.overlaps(agent.shape, agent.pose)
    forbidden = any(
        np.hypot(*(agent.pose[:2] - p.position)) <= p.radius and np.isinf(p.cost)
        for p in agent.penalties
    )
    assert (model.stay_units[0] >= FAR) == (start_inside or forbidden)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000))
def test_both_distance_fields_agree_with_relaxation(seed: int) -> None:
    rng = np.random.default_rng(seed)
    free = rng.random((7, 6)) < 0.8
    goal = np.where(free & (rng.random((7, 6)) < 0.15), rng.integers(0, 6, (7, 6)) * 700, FAR)
    step = np.full((7, 6), 1000)
    expected = goal.astype(np.float64)
    for _ in range(60):
        padded = np.pad(expected, 1, constant_values=np.inf)
        price = np.pad(step, 1).astype(np.float64)
        around = [
            (padded + price)[2:, 1:-1],
            (padded + price)[:-2, 1:-1],
            (padded + price)[1:-1, 2:],
            (padded + price)[1:-1, :-2],
        ]
        expected = np.where(free, np.minimum(expected, np.min(around, axis=0)), np.inf)
    expected = np.where(expected >= FAR, FAR, expected)
    assert np.array_equal(uniform_distance(free, goal, 1000), expected)
    assert np.array_equal(weighted_distance(free, goal, step), expected)
