"""Rearrangements of generated problems, and whether these can be solved from there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from mamo_core.errors import InputError
from mamo_core.interfaces.search_strategy import ProgressCallback
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Budget, SolutionStatus
from mamo_planners.learning.data import Data, Explored, Point, Settings
from mamo_planners.search.features import Features, features_of
from mamo_planners.search.rearrangement import RearrangementSearch
from mamo_planners.search.vertices import Vertex

if TYPE_CHECKING:
    from mamo_core.cli.workbench import Workbench

BREADTH_FIRST = "em4m"
DEPTH_FIRST = "im4m"


@dataclass(frozen=True, eq=False)
class Found:
    """A rearrangement, and what it looks like under the NGR of its graph."""

    vertex: int
    actions: int
    state: SceneState
    features: Features


def gather(
    bench: Workbench, settings: Settings, count: int, data: Data, tell: ProgressCallback
) -> None:
    """Add what is missing of the first so many problems."""
    for place in range(count):
        seed = settings.seed + place
        if not data.complete(seed):
            solved = sum(point.solved for point in data.points.values())
            so_far = f"{len(data.points)} rearrangements, {solved} solved"
            tell(f"problem {place + 1} of {count}: {so_far}")
            _gather_problem(bench, settings, place, data)


def _gather_problem(bench: Workbench, settings: Settings, place: int, data: Data) -> None:
    seed = settings.seed + place
    movables, level = kind_of(settings, place)
    try:
        problem = bench.shelf(movables=movables, seed=seed, level=level)
    except InputError as error:
        data.add(Explored(seed, f"{movables} movables, {level}", 0, left_out=str(error)))
        return
    found, cut = explore(bench, problem, settings, seed)
    if seed not in data.explored:
        data.add(Explored(seed, problem.name, len(found), cut))
    _check_same(data, seed, found)
    for item in found:
        if (seed, item.vertex) not in data.points:
            data.add(label(bench, problem, settings, seed, item))


def kind_of(settings: Settings, place: int) -> tuple[int, str]:
    """Number of movables and level of the problem at that place: they take turns."""
    level, movables = divmod(place, len(settings.movables))
    return settings.movables[movables], settings.levels[level % len(settings.levels)]


def explore(
    bench: Workbench, problem: Problem, settings: Settings, seed: int
) -> tuple[list[Found], bool]:
    """The rearrangements of E-M4M's breadth-first graph, until there is a plan or the work is up.

    Also whether it was cut short by its budget. What the database says and nobody has executed is
    left out.
    """
    found: list[Found] = []

    def watch(region: SweptRegion, vertices: Sequence[Vertex]) -> None:
        for number, vertex in enumerate(vertices):
            if not vertex.stand.predicted:
                features = features_of(problem, vertex.state, region)
                found.append(Found(number, vertex.depth, vertex.state, features))

    changes = (
        "search.order=breadth_first",
        f"search.expansions={settings.expansions}",
        f"search.visits={settings.visits}",
    )
    search = bench.planner(BREADTH_FIRST, problem, changes).search
    assert isinstance(search, RearrangementSearch), "the search of the recipe"
    budget = Budget(settings.budget)
    search.solve(budget, np.random.default_rng(seed), _in_silence, watch)
    return found, budget.exhausted


def label(bench: Workbench, problem: Problem, settings: Settings, seed: int, found: Found) -> Point:
    """Whether the depth-first search finds a plan from there, with the arm at home."""
    start = replace(problem, initial=found.state.with_joints(problem.home))
    planner = bench.planner(DEPTH_FIRST, start, (f"search.visits={settings.attempt}",))
    budget = Budget(settings.budget)
    rng = np.random.default_rng([seed, found.vertex])
    status = planner.search.solve(budget, rng, _in_silence).status
    solved = status is SolutionStatus.SOLVED
    cut = not solved and budget.exhausted
    return Point(seed, found.vertex, found.actions, found.features, solved, cut)


def _check_same(data: Data, seed: int, found: Sequence[Found]) -> None:
    """The graph is searched again to go on with a problem: what is labelled must belong to it."""
    here = {item.vertex: item.features for item in found}
    known = data.points_of(seed)
    same = all(here.get(point.vertex) == point.features for point in known)
    if not same or data.explored[seed].vertices != len(found):
        raise InputError(
            f"{data.path}: this version finds other rearrangements of the problem with seed {seed} "
            "than stand there; expected the same version or another file"
        )


def _in_silence(text: str) -> None:
    """A search of seconds among hundreds has nothing to tell."""
