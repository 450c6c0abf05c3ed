"""A planner whose parts keep what they were asked and what they answered."""

from __future__ import annotations

import copy
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from mamo_core.hookspecs import Component
from mamo_core.interfaces.action_generator import ActionGenerator, ActionRequest
from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.interfaces.retrieval import Retrieval, RetrievalPlanner
from mamo_core.plugins import Registry
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array
from mamo_core.types.mapf import MAPFBudget, MAPFProblem, MAPFSolution
from mamo_core.types.motion import Motion
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Statistics


@dataclass
class Offer:
    """What an action generator offers for one request.

    ``asked``: how many of the candidates the search asked for; ``causes``: why there are no more.
    """

    state: SceneState
    request: ActionRequest
    candidates: tuple[RearrangementAction, ...]
    causes: dict[str, int]
    asked: int = 0


@dataclass
class Answer:
    """Paths of the pathfinding solver, and the offers that were made for them."""

    solution: MAPFSolution
    offers: list[Offer] = field(default_factory=list)

    @property
    def ways(self) -> dict[str, Array]:
        """Paths (k, 2) of those that are to move, by name."""
        return {name: way for name, way in self.solution.paths.items() if len(way) > 1}


@dataclass
class Notes:
    """Everything in the order in which it happened."""

    retrievals: list[Retrieval] = field(default_factory=list)
    regions: list[SweptRegion] = field(default_factory=list)
    answers: list[Answer] = field(default_factory=list)


class _WatchedRetrieval(RetrievalPlanner):
    def __init__(self, inner: RetrievalPlanner, notes: Notes) -> None:
        self._inner, self._notes = inner, notes

    def plan(
        self,
        state: SceneState,
        rng: np.random.Generator,
        *,
        ignore_movables: bool = False,
        avoid: Collection[int] = (),
    ) -> Retrieval:
        found = self._inner.plan(state, rng, ignore_movables=ignore_movables, avoid=avoid)
        self._notes.retrievals.append(found)
        return found

    def swept_region(self, state: SceneState, motion: Motion) -> SweptRegion:
        region = self._inner.swept_region(state, motion)
        self._notes.regions.append(region)
        return region


class _WatchedMAPF(MAPFSolver):
    def __init__(self, inner: MAPFSolver, notes: Notes) -> None:
        self._inner, self._notes = inner, notes

    def solve(
        self, problem: MAPFProblem, budget: MAPFBudget, rng: np.random.Generator
    ) -> MAPFSolution:
        solution = self._inner.solve(problem, budget, rng)
        self._notes.answers.append(Answer(solution))
        return solution


class _WatchedActions(ActionGenerator):
    def __init__(self, inner: ActionGenerator, notes: Notes) -> None:
        self._inner, self._notes = inner, notes

    def propose(
        self,
        state: SceneState,
        request: ActionRequest,
        rng: np.random.Generator,
        statistics: Statistics,
    ) -> Iterator[RearrangementAction]:
        """The search stops at the first good one; a copy of the generator shows the others."""
        apart = Statistics()
        everything = tuple(self._inner.propose(state, request, copy.deepcopy(rng), apart))
        causes = {key.rpartition("/")[2]: times for key, times in apart.causes.items()}
        offer = Offer(state, request, everything, causes)
        self._notes.answers[-1].offers.append(offer)
        for action in self._inner.propose(state, request, rng, statistics):
            offer.asked += 1
            yield action


_WATCHERS: dict[str, Callable[[Any, Notes], Any]] = {
    "retrieval": _WatchedRetrieval,
    "mapf": _WatchedMAPF,
    "action": _WatchedActions,
}


def watched(registry: Registry, notes: Notes) -> Registry:
    """The same components, whose parts take notes."""
    return replace(
        registry,
        registered=tuple(
            replace(item, component=_watched(item.component, _WATCHERS[item.role], notes))
            if item.role in _WATCHERS
            else item
            for item in registry.registered
        ),
    )


def _watched(component: Component, watcher: Callable[[Any, Notes], Any], notes: Notes) -> Component:
    def build(context: Any, options: Any) -> Any:
        return watcher(component.build(context, options), notes)

    return replace(component, build=build)
