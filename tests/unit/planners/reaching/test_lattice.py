"""The lattice: whole steps from the start, within limits."""

from dataclasses import replace

import numpy as np
import pytest
from mamo_planners.reaching.lattice import Lattice

from mamo_core.testing.gantry_arm import gantry_arm

LARGE, SMALL = np.radians(7.0), np.radians(4.0)


def arm(lower=-1.0, upper=1.0, dof=7, home=0.0):
    sizes = {"lower": lower, "upper": upper, "home": home}
    names = tuple(f"joint_{k}" for k in range(dof))
    values = {k: np.full(dof, float(v)) for k, v in sizes.items()}
    return replace(gantry_arm(), joint_names=names, **values)


def lattice_of(start=None, **limits):
    model = arm(**limits)
    return Lattice(model, np.zeros(model.dof) if start is None else np.array(start), 7.0, 4.0)


def test_four_large_joints_and_the_rest_small():
    assert lattice_of().steps == pytest.approx([LARGE] * 4 + [SMALL] * 3)


def test_configurations_lie_whole_steps_from_the_start():
    start = np.linspace(-0.3, 0.3, 7)
    lattice = lattice_of(start)
    assert np.array_equal(lattice.configuration(lattice.start), start)
    moved = lattice.configuration((1, 0, 0, 0, 0, 0, -2)) - start
    assert moved == pytest.approx([LARGE, 0, 0, 0, 0, 0, -2 * SMALL])


def test_a_successor_moves_one_joint_by_one_step():
    lattice = lattice_of()
    found = lattice.successors(lattice.start)
    moves = np.array(found)
    assert len(set(found)) == 14
    assert (np.abs(moves).sum(axis=1) == 1).all()


def test_successors_stay_within_limits():
    lattice = lattice_of(lower=-1.5 * SMALL, upper=1.5 * SMALL)
    # The first four joints have no step that is small enough.
    assert sorted(np.flatnonzero(c).tolist() for c in lattice.successors(lattice.start)) == [
        [k] for k in (4, 4, 5, 5, 6, 6)
    ]
    at_the_limit = (0, 0, 0, 0, 1, 0, 0)
    found = lattice.successors(at_the_limit)
    assert (0, 0, 0, 0, 2, 0, 0) not in found
    assert lattice.start in found
    assert len(found) == 5


def test_a_start_beyond_a_limit_is_still_a_cell():
    lattice = lattice_of(np.full(7, 1.0 + 1e-7))
    assert lattice.nearest(np.full(7, 1.0 + 1e-7)) == lattice.start
    assert len(lattice.successors(lattice.start)) == 7


def test_joints_without_limits_are_not_turned_round_and_round():
    lattice = lattice_of(lower=-np.inf, upper=np.inf, home=0.5)
    assert lattice.configuration(lattice.nearest(np.full(7, 100.0))).max() <= 0.5 + np.pi
    assert lattice.configuration(lattice.nearest(np.full(7, -100.0))).min() >= 0.5 - np.pi


def test_nearest_rounds_and_clips():
    lattice = lattice_of()
    q = np.array([1.4 * LARGE, 1.6 * LARGE, 0, 0, 0, -0.6 * SMALL, 9.0])
    assert lattice.nearest(q) == (1, 2, 0, 0, 0, -1, int(1.0 / SMALL))


def test_rounding_a_cell_gives_the_cell():
    lattice = Lattice(gantry_arm(), np.array([-0.2, 0.0, 0.05, 0.0]), 2.0, 2.0)
    cell = (5, -3, 2, 7)
    assert lattice.nearest(lattice.configuration(cell)) == cell
