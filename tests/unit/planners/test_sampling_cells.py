"""The cells of KPIECE: where a tree grows next."""

from types import SimpleNamespace

import numpy as np
import pytest
from mamo_planners.baselines.sampling.cells import BAD, GOOD, WIDER, Cells

SIDES = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]


def node(name="n"):
    return SimpleNamespace(name=name)


def grid(coordinates, *, levels=1, border=1.0, size=0.1):
    """Cells with one node in the middle of each."""
    cells = Cells(size, levels, border)
    for coordinate in coordinates:
        assert cells.add(node(coordinate), (np.array(coordinate) + 0.5) * size, 1.0)
    return cells


def picked(cells, times=400, seed=0):
    rng = np.random.default_rng(seed)
    found = [cells.select(rng) for _ in range(times)]
    return [chain for chain, _ in found], [chosen.name for _, chosen in found]


def test_a_cell_is_new_but_once():
    cells = Cells(0.1, 2, 0.9)
    assert cells.add(node(), np.array([0.01, 0.01, 0.01]), 1.0)
    assert not cells.add(node(), np.array([0.09, 0.09, 0.09]), 1.0)
    assert cells.add(node(), np.array([-0.01, 0.01, 0.01]), 1.0)


def test_interior_cells_have_neighbours_on_all_sides():
    inside, *around = [(0, 0, 0), *SIDES]
    cells = grid([inside, *around])
    _, names = picked(cells)
    assert inside not in names, "only cells at the border, at a share of 1"
    _, names = picked(grid([inside, *around[:-1]]))
    assert inside in names, "with one side open it is at the border"
    _, names = picked(grid([inside, *around], border=0.0))
    share = names.count(inside) / len(names)
    assert share == pytest.approx(1 / 7, abs=0.06), "at least the share of cells at the border"


def test_what_was_grown_often_or_is_full_comes_later():
    cells = Cells(0.1, 1, 0.9)
    for count, x in ((10, 0.05), (1, 0.55)):
        for _ in range(count):
            cells.add(node(x), np.array([x, 0.0, 0.0]), 1.0)
    _, names = picked(cells, times=11)
    assert names[0] == 0.55
    assert names.count(0.55) > names.count(0.05) >= 1


def test_cells_near_a_goal_come_first():
    cells = Cells(0.1, 1, 0.9)
    for x, distance in ((0.05, 1.0), (0.55, 0.1)):
        cells.add(node(x), np.array([x, 0.0, 0.0]), distance)
    _, names = picked(cells, times=9)
    assert names.count(0.55) >= 7


def test_actions_that_lead_nowhere_cost_more():
    for progress, factor in ((True, GOOD), (False, BAD)):
        cells = grid([(0, 0, 0)])
        chain, _ = cells.select(np.random.default_rng(0))
        before = chain[0].score
        cells.reward(chain, progress)
        assert chain[0].score == pytest.approx(factor * before)


def test_levels_are_nested():
    coordinates = [(x, y, 0) for x in range(-6, 6) for y in range(3)]
    cells = grid(coordinates, levels=2)
    chains, names = picked(cells)
    for chain, name in zip(chains, names, strict=True):
        wide, fine = chain
        assert fine.coordinate == name
        assert wide.coordinate == tuple(value // WIDER for value in name)
        assert fine in wide.children
    assert len({chain[0].coordinate for chain in chains}) == 4
    assert set(names) == set(coordinates)


def test_recent_nodes_are_preferred():
    cells = Cells(0.1, 1, 0.9)
    for name in range(30):
        cells.add(node(name), np.zeros(3), 1.0)
    _, names = picked(cells, times=600)
    assert sum(name >= 15 for name in names) > 2 * sum(name < 15 for name in names) > 0
