"""Gathering: the same every time, and after an interruption it goes on where it was."""

from types import SimpleNamespace

import pytest
from mamo_planners.learning import gather as module
from mamo_planners.learning.data import Point, Settings, open_data
from mamo_planners.learning.gather import Found, gather, kind_of
from mamo_planners.search.features import Features

from mamo_core.cli.workbench import Workbench
from mamo_core.errors import InputError
from mamo_core.plugins import discover

SETTINGS = Settings(4, (10, 15), ("medium", "easy"), 4, 6, 3, 600.0)


def quiet(text):
    pass


def run(bench, path, count=3):
    with open_data(path, SETTINGS) as data:
        gather(bench, SETTINGS, count, data, quiet)
        return dict(data.points)


def test_a_small_problem_gives_the_same_twice(tmp_path):
    bench = Workbench(discover())
    first, second = (tmp_path / name for name in ("a.jsonl", "b.jsonl"))
    points = run(bench, first, count=1)
    run(bench, second, count=1)
    assert first.read_bytes() == second.read_bytes()
    assert [key[0] for key in points] == [4] * len(points)
    assert points[4, 0].actions == 0
    assert points[4, 0].features.count == 2
    assert any(point.actions > 0 for point in points.values())
    assert any(point.solved for point in points.values())


class Counted:
    """Stands in for the searches: vertex n of a problem has the share n / 10, odd ones solve."""

    def __init__(self, monkeypatch, vertices=3):
        self.vertices = vertices
        self.explored, self.labelled = [], []
        self.fails_after = None
        monkeypatch.setattr(module, "explore", self.explore)
        monkeypatch.setattr(module, "label", self.label)

    def shelf(self, *, movables, seed, level):
        if seed == 6:
            raise InputError("no room")
        return SimpleNamespace(name=f"{movables}_{level}_{seed}")

    def explore(self, bench, problem, settings, seed):
        self.explored.append(seed)
        share = 0.1 if self.vertices == 3 else 0.2
        return [Found(n, n, None, Features(n * share, 0, ())) for n in range(self.vertices)], False

    def label(self, bench, problem, settings, seed, found):
        if len(self.labelled) == self.fails_after:
            raise KeyboardInterrupt
        self.labelled.append((seed, found.vertex))
        return Point(seed, found.vertex, found.actions, found.features, found.vertex % 2 == 1)


@pytest.mark.parametrize("done", range(6))
def test_after_an_interruption_it_goes_on(tmp_path, monkeypatch, done):
    bench = Counted(monkeypatch)
    whole = tmp_path / "whole.jsonl"
    run(bench, whole)
    bench.labelled.clear()
    bench.fails_after = done
    path = tmp_path / "data.jsonl"
    with pytest.raises(KeyboardInterrupt):
        run(bench, path)
    bench.fails_after = None
    run(bench, path)
    assert path.read_bytes() == whole.read_bytes()
    assert bench.labelled == [(seed, n) for seed in (4, 5) for n in range(3)]


def test_what_is_complete_is_left_alone_and_more_problems_extend_it(tmp_path, monkeypatch):
    bench = Counted(monkeypatch)
    path = tmp_path / "data.jsonl"
    run(bench, path, count=1)
    run(bench, path, count=2)
    run(bench, path, count=2)
    assert bench.explored == [4, 5]


def test_a_problem_that_cannot_be_generated_is_noted(tmp_path, monkeypatch):
    bench = Counted(monkeypatch)
    path = tmp_path / "data.jsonl"
    run(bench, path)
    with open_data(path, SETTINGS) as data:
        assert data.explored[6].left_out == "no room"
        assert data.complete(6)


def test_rearrangements_of_another_version_are_not_mixed(tmp_path, monkeypatch):
    bench = Counted(monkeypatch)
    path = tmp_path / "data.jsonl"
    bench.fails_after = 2
    with pytest.raises(KeyboardInterrupt):
        run(bench, path)
    other = Counted(monkeypatch, vertices=4)
    with pytest.raises(InputError, match="finds other rearrangements of the problem with seed 4"):
        run(other, path)


def test_numbers_and_levels_take_turns():
    kinds = [kind_of(SETTINGS, place) for place in range(5)]
    assert kinds == [(10, "medium"), (15, "medium"), (10, "easy"), (15, "easy"), (10, "medium")]
