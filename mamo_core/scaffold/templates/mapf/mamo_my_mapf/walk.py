"""The cheapest walk of one agent in space and time, past agents whose walks are known."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count

import numpy as np

from mamo_core.types.geometry import Array
from mamo_core.types.mapf import MAPFAgent, MAPFProblem
from mamo_my_mapf.gaps import Gap, Ground, same_height

_STEPS = ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1))
_SLACK = 1e-9

Cell = tuple[int, int]
State = tuple[int, int, int]
"""Lattice cell, counted from the agent's start, and time step."""

Entry = tuple[float, int, State, State | None, bool]
"""Of the queue: cost, number, state, the state before, and whether the walk ends there."""


class OutOfWorkError(Exception):
    """The budget is used up."""


class Work:
    """Counts expansions, of which there are ``left``."""

    def __init__(self, left: int) -> None:
        self.left, self.done = left, 0

    def spend(self) -> None:
        """One expansion more; OutOfWorkError if none is left."""
        if self.done >= self.left:
            raise OutOfWorkError
        self.done += 1


@dataclass(frozen=True, eq=False)
class Walk:
    """``path`` (T + 1, 2) m, world, without waits at its end; ``cost`` in lattice steps."""

    path: Array
    cost: float


class Passer:
    """An agent that walks already: who comes later keeps ``margin`` away from it."""

    def __init__(
        self, problem: MAPFProblem, agent: MAPFAgent, other: MAPFAgent, walk: Walk
    ) -> None:
        self._gap = Gap.between(agent.shape, agent.pose, other.shape, other.pose)
        self._meets = same_height(agent.shape, agent.pose, other.shape, other.pose)
        self._least, self._walk = problem.margin - _SLACK, walk.path
        moves = np.flatnonzero((walk.path != walk.path[0]).any(axis=1))
        self._leaves = float(moves[0]) if moves.size else np.inf
        self.end = len(walk.path) - 1

    def lets(self, place: Array, time: int, *, untouched: bool) -> bool:
        """Whether an agent may be at ``place`` (2,) then.

        Two that have not moved may stand as near as they did (``untouched``: the agent has not).
        """
        if not self._meets or (untouched and time < self._leaves):
            return True
        there = self._walk[min(time, self.end)]
        return self._gap.at(place - there) >= self._least


def walk(
    problem: MAPFProblem, agent: MAPFAgent, others: Sequence[Passer], work: Work
) -> Walk | None:
    """The cheapest walk to a goal where the agent can stay; None if there is none.

    Raises:
        OutOfWorkError: it was not found within the work that is left.
    """
    return _Search(problem, agent, others, work).run()


class _Search:
    """Dijkstra's algorithm over cells and times; after all others have arrived time stands still.

    A goal is reached by one more step in thought, which costs what it costs to end there.
    """

    def __init__(
        self, problem: MAPFProblem, agent: MAPFAgent, others: Sequence[Passer], work: Work
    ) -> None:
        self._problem, self._agent, self._others, self._work = problem, agent, others, work
        self._ground = Ground(problem, agent)
        self._last = 1 + max((other.end for other in others), default=0)
        self._passable: dict[Cell, bool] = {}
        self._number = count()

    def run(self) -> Walk | None:
        start = (0, 0, 0)
        parents: dict[State, State | None] = {}
        queue: list[Entry] = []
        self._push(queue, 0.0, start, None, ends=False)
        while queue:
            cost, _, state, parent, ends = heapq.heappop(queue)
            if ends:
                return Walk(self._path(state, parents), cost)
            if state in parents:
                continue
            self._work.spend()
            parents[state] = parent
            goal_cost = self._ground.goal_cost(self._shift(state))
            if np.isfinite(goal_cost) and self._stays(state):
                self._push(queue, cost + goal_cost, state, parent, ends=True)
            for following, step_cost in self._following(state):
                self._push(queue, cost + step_cost, following, state, ends=False)
        return None

    def _push(
        self, queue: list[Entry], cost: float, state: State, parent: State | None, *, ends: bool
    ) -> None:
        heapq.heappush(queue, (cost, next(self._number), state, parent, ends))

    def _following(self, state: State) -> Iterator[tuple[State, float]]:
        """Where a step or a wait leads, and what it costs."""
        i, j, time = state
        for di, dj in _STEPS:
            following = (i + di, j + dj, min(time + 1, self._last))
            waits = (di, dj) == (0, 0)
            if following == state or not self._may_be(following, waits=waits):
                continue
            shift = self._shift(following)
            yield following, self._problem.wait_cost if waits else self._ground.step_cost(shift)

    def _may_be(self, state: State, *, waits: bool) -> bool:
        i, j, time = state
        if (i, j) not in self._passable:
            self._passable[i, j] = self._ground.passable(self._shift(state))
        place = self._agent.pose[:2] + self._shift(state)
        untouched = waits and (i, j) == (0, 0)
        return self._passable[i, j] and all(
            other.lets(place, time, untouched=untouched) for other in self._others
        )

    def _stays(self, state: State) -> bool:
        """Whether nobody comes by later."""
        i, j, time = state
        return all(self._may_be((i, j, t), waits=True) for t in range(time + 1, self._last + 1))

    def _shift(self, state: State) -> Array:
        return self._problem.resolution * np.array(state[:2], dtype=np.float64)

    def _path(self, state: State, parents: dict[State, State | None]) -> Array:
        shifts = []
        at: State | None = state
        while at is not None:
            shifts.append(self._shift(at))
            at = parents[at]
        return self._agent.pose[:2] + np.array(shifts[::-1])
