"""Worlds that are a little off: never by more than is said, and the same ones each time."""

import numpy as np
import pytest

from mamo_core.testing.scenes import two_blockers
from mamo_core.types.deviation import (
    NEAR,
    NEIGHBOURS,
    Deviation,
    moved,
    neighbours,
    other_parameters,
)

WIDE = Deviation(0.005, 0.05, 0.2)


def yaws(poses):
    """Of things that stand upright."""
    return 2.0 * np.arctan2(poses[:, 6], poses[:, 3])


@pytest.fixture
def problem():
    return two_blockers().problem


def off(poses, before):
    """How far each pose is away, m, and turned, rad; nothing else changes."""
    assert np.array_equal(poses[:, 2], before[:, 2])
    assert np.array_equal(poses[:, 4:6], before[:, 4:6])
    return np.linalg.norm((poses - before)[:, :2], axis=1), np.abs(yaws(poses) - yaws(before))


def test_draws_stay_within_their_bounds_and_reach_them(problem):
    before = np.repeat(problem.initial.object_poses, 500, axis=0)
    shifts, turns = off(moved(before, WIDE, np.random.default_rng(0)), before)
    for found, bound in ((shifts, WIDE.position), (turns, WIDE.angle)):
        assert found.max() <= bound * (1.0 + 1e-9)
        assert found.max() > 0.95 * bound


def test_the_same_generator_draws_the_same(problem):
    poses = problem.initial.object_poses
    one, same, other = (moved(poses, WIDE, np.random.default_rng(seed)) for seed in (0, 0, 1))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


def test_neighbours_are_few_near_and_always_the_same(problem):
    starts = neighbours(problem)
    assert len(starts) == NEIGHBOURS
    for one, same in zip(starts, neighbours(problem), strict=True):
        assert np.array_equal(one.object_poses, same.object_poses)
        assert np.array_equal(one.joint_positions, problem.initial.joint_positions)
        shifts, turns = off(one.object_poses, problem.initial.object_poses)
        assert 0.0 < shifts.min() <= shifts.max() <= NEAR.position * (1.0 + 1e-9)
        assert turns.max() <= NEAR.angle * (1.0 + 1e-9)
    assert len({start.object_poses.tobytes() for start in starts}) == NEIGHBOURS


def test_masses_and_frictions_are_about_the_problems(problem):
    rng = np.random.default_rng(0)
    assert other_parameters(problem, NEAR, rng) is None
    for _ in range(50):
        found = other_parameters(problem, WIDE, rng)
        for item in problem.scene.objects:
            for now, own in (
                (found.masses[item.name], item.mass),
                (found.frictions[item.name], item.friction),
            ):
                assert now != own
                assert now / own == pytest.approx(1.0, abs=0.2)
