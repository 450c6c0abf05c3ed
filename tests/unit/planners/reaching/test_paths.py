"""Small things of the searches: paths, explored states, counted work, rounds."""

import numpy as np
import pytest
from mamo_planners.reaching.explored import Explored
from mamo_planners.reaching.shortcuts import straightened
from mamo_planners.reaching.spamp import luby
from mamo_planners.reaching.work import EXPANSION_SECONDS, STEP_SECONDS, Work

from mamo_core.interfaces.collision_checker import CollisionWorld


class NoFurtherThan(CollisionWorld):
    """Edges up to some length are free."""

    def __init__(self, length):
        self.length = length

    def free(self, configurations):
        return np.ones(len(configurations), dtype=bool)

    def edges_free(self, starts, ends):
        return np.linalg.norm(ends - starts, axis=1) <= self.length + 1e-9


LINE = np.arange(8, dtype=float)[:, None]


@pytest.mark.parametrize(
    ("length", "kept"),
    [(10.0, [0, 7]), (3.0, [0, 3, 6, 7]), (0.5, list(range(8)))],
)
def test_straightened(length, kept):
    assert straightened(LINE, NoFurtherThan(length))[:, 0].tolist() == kept


def test_straightened_jumps_to_the_last_free_one():
    """Not to the first that is blocked: what lies behind it may be free again."""
    there_and_back = np.array([[0.0], [5.0], [6.0], [1.0]])
    assert straightened(there_and_back, NoFurtherThan(1.0))[:, 0].tolist() == [0.0, 1.0]


def test_a_single_configuration_stays():
    assert straightened(LINE[:1], NoFurtherThan(0.0)).tolist() == [[0.0]]


def test_explored():
    explored = Explored()
    root = explored.add("root", np.array([0.0]), -1)
    left = explored.add("left", np.array([1.0]), root)
    right = explored.add("right", np.array([2.0]), root)
    leaf = explored.add("leaf", np.array([3.0]), right)
    assert [root, left, right, leaf] == [0, 1, 2, 3]
    assert explored.costs == [0.0, 1.0, 1.0, 2.0]
    assert explored.ancestry(leaf) == [root, right, leaf]
    assert explored.way(leaf).tolist() == [[0.0], [2.0], [3.0]]
    assert explored.way(root).shape == (1, 1)
    assert "leaf" in explored
    assert "twig" not in explored


def test_luby():
    assert [luby(n) for n in range(1, 16)] == [1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8]


def test_work_is_counted_not_measured():
    work = Work()
    assert work.expanded() == EXPANSION_SECONDS
    assert work.simulated(1000) == pytest.approx(1000 * STEP_SECONDS)
    assert work.seconds == pytest.approx(EXPANSION_SECONDS + 1000 * STEP_SECONDS)


def test_luby_spends_as_much_on_each_length():
    terms = [luby(n) for n in range(1, 2**7)]
    assert [sum(t for t in terms if t == 2**k) for k in range(7)] == [64] * 7
