"""Planning phase of Selective Simulation: motions are simulated where they meet what matters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mamo_core.types.geometry import Array, BoolArray, yaw_of
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.scene import Mobility, SceneState
from mamo_core.types.solution import Budget, Statistics
from mamo_planners.baselines.options import SelectiveSimulationOptions
from mamo_planners.reaching.explored import Explored
from mamo_planners.reaching.goals import Goal
from mamo_planners.reaching.lattice import Cell, Lattice
from mamo_planners.reaching.motions import Motions
from mamo_planners.reaching.queues import Queues
from mamo_planners.reaching.scenery import Scenery
from mamo_planners.reaching.soft_duplicates import SoftDuplicates, inflated
from mamo_planners.reaching.stand import ReachingParts
from mamo_planners.reaching.work import Work
from mamo_planners.search.rollouts import Rollouts
from mamo_planners.search.stand import Engine, Line

Key = tuple[Cell, tuple[int, ...]]
"""The arm's cell, and where the relevant objects are."""


@dataclass(frozen=True, eq=False)
class Planned:
    """A ``path`` (k, dof) from the start to a goal; ``simulated`` (k - 1,): which edges were."""

    path: Array
    goal: Goal
    simulated: BoolArray


@dataclass(frozen=True, eq=False)
class _Moved:
    """The ``state`` after an edge, and whether an engine was asked for it."""

    state: SceneState
    simulated: bool


class SelectivePlanning:
    """One planning phase; ``parts.backend`` simulates the ``reduced`` problem.

    ``refuted``: edges (2, dof) that are not valid with all objects, whatever is relevant.
    """

    def __init__(
        self,
        parts: ReachingParts,
        reduced: Problem,
        relevant: tuple[str, ...],
        refuted: list[Array],
        scenery: Scenery,
        options: SelectiveSimulationOptions,
        statistics: Statistics,
        budget: Budget,
    ) -> None:
        self._parts, self._reduced, self._scenery = parts, reduced, scenery
        self._options, self._statistics, self._budget = options, statistics, budget
        self._start = parts.problem.initial.joint_positions
        self._lattice = Lattice(
            parts.arm, self._start, options.large_step_deg, options.small_step_deg
        )
        self._motions = Motions(parts.arm, parts.kinematics, options, scenery.goals.opening)
        self._rollouts = Rollouts(statistics, budget)
        self._engine = Engine("reduced", parts.backend)
        self._places = [reduced.scene.index(name) for name in relevant]
        objects = parts.problem.scene.objects
        self._irrelevant = [
            o.name for o in objects if o.mobility is Mobility.MOVABLE and o.name not in relevant
        ]
        self._rows = [parts.problem.scene.index(o.name) for o in reduced.scene.objects]
        self._queues = Queues(1 + len(scenery.goals.known), options.w1, options.w2)
        self._explored: Explored[Key] = Explored()
        self._found: list[_Moved] = []
        self._work = Work()
        self._duplicates = SoftDuplicates(options.beta)
        self._put_off: set[int] = set()
        self._refuted = {edge.tobytes() for edge in refuted}

    def solve(self, rng: np.random.Generator) -> Planned | None:
        """A path to a goal; None when all is expanded or a limit is reached."""
        self._add(self._lattice.start, self._start, _Moved(self._reduced.initial, False), -1)
        for _ in range(self._options.expansions):
            popped = self._queues.pop() if not self._budget.exhausted else None
            if popped is None:
                return None
            before = self._work.seconds
            planned = self._expand(*popped, rng)
            self._queues.spend(popped[1], self._work.seconds - before)
            if planned is not None:
                return planned
        return None

    def _expand(self, state: int, queue: int, rng: np.random.Generator) -> Planned | None:
        self._work.expanded()
        self._statistics.counts["expansions"] += 1
        q = self._explored.configurations[state]
        goal = self._goal_from(q, rng)
        cells = self._lattice.successors(self._explored.keys[state][0])
        ends = np.array([self._lattice.configuration(cell) for cell in cells])
        tried = ends if goal is None else np.vstack([ends, goal.configuration])
        is_new = state not in self._put_off
        if is_new and self._duplicates.near(q) and not self._free_of_relevant(state, tried).all():
            self._put_off_from(queue, state, q)
            return None
        if goal is not None:
            (last,) = self._moved(state, goal.configuration[None, :])
            if last is not None:
                return self._planned(state, goal, last)
        for cell, end, after in zip(cells, ends, self._moved(state, ends), strict=True):
            if after is not None:
                self._add(cell, end, after, state)
        return None

    def _planned(self, state: int, goal: Goal, last: _Moved) -> Planned:
        edges = [self._found[number] for number in self._explored.ancestry(state)[1:]]
        path = np.vstack([self._explored.way(state), goal.configuration])
        return Planned(path, goal, np.array([edge.simulated for edge in (*edges, last)]))

    def _goal_from(self, q: Array, rng: np.random.Generator) -> Goal | None:
        """Where the straight motion to the goal is tried, the goal."""
        if self._scenery.field.distance(self._tool(q)) > self._options.snap_distance:
            return None
        return self._scenery.goals.near(q, rng)

    def _put_off_from(self, queue: int, state: int, q: Array) -> None:
        self._statistics.counts["soft_duplicates"] += 1
        self._put_off.add(state)
        put_off = inflated(self._heuristics(q)[queue])
        self._queues.push_into(queue, state, self._explored.costs[state], put_off)

    def _moved(self, state: int, ends: Array) -> list[_Moved | None]:
        """What straight motions from a state to ``ends`` (k, dof) lead to; None: not valid."""
        q, before = self._explored.configurations[state], self._found[state].state
        starts = np.repeat(q[None, :], len(ends), axis=0)
        edges = np.stack([starts, ends], axis=1)
        allowed = self._scenery.fixed.edges_free(starts, ends)
        allowed &= [edge.tobytes() not in self._refuted for edge in edges]
        untouched = self._free_of_relevant(state, ends)
        return [
            self._after(q, before, end, touching=not free) if ok else None
            for end, ok, free in zip(ends, allowed, untouched, strict=True)
        ]

    def _after(self, q: Array, before: SceneState, end: Array, *, touching: bool) -> _Moved | None:
        after = self._simulated(q, before, end) if touching else before.with_joints(end)
        return _Moved(after, touching) if after is not None else None

    def _free_of_relevant(self, state: int, ends: Array) -> BoolArray:
        """Which motions to ``ends`` (k, dof) touch no relevant object: bool (k,)."""
        if not self._places:
            return np.ones(len(ends), dtype=np.bool_)
        poses = self._parts.problem.initial.object_poses.copy()
        poses[self._rows] = self._found[state].state.object_poses
        world = self._parts.collision.world(
            poses, opening=self._scenery.goals.opening, ignore=self._irrelevant
        )
        starts = np.repeat(self._explored.configurations[state][None, :], len(ends), axis=0)
        return world.edges_free(starts, ends)

    def _simulated(self, q: Array, before: SceneState, end: Array) -> SceneState | None:
        segment = self._motions.sweep(np.stack([q, end]))
        line = Line(self._engine, before.with_joints(q))
        result = self._rollouts.one(line, Motion((segment,), segment.opening), None)
        self._work.simulated(result.steps)
        self._statistics.counts["steps"] += result.steps
        if not result.valid:
            self._duplicates.failed(q)
            return None
        return result.final_state.with_joints(end)

    def _add(self, cell: Cell, q: Array, after: _Moved, parent: int) -> None:
        key = (cell, self._placed(after.state))
        if key in self._explored:
            return
        number = self._explored.add(key, q, parent)
        self._found.append(after)
        self._queues.push(number, self._explored.costs[number], self._heuristics(q))

    def _placed(self, state: SceneState) -> tuple[int, ...]:
        """Where the relevant objects are, to within a cell."""
        cells: list[int] = []
        for place in self._places:
            pose = state.object_poses[place]
            cells += np.rint(pose[:3] / self._options.position_cell).astype(int).tolist()
            cells.append(round(yaw_of(pose) / np.radians(self._options.yaw_cell_deg)))
        return tuple(cells)

    def _heuristics(self, q: Array) -> list[float]:
        """Primitives to go: around obstacles for the tool, and straight to each known goal."""
        step = float(self._lattice.steps.max())
        goals = self._scenery.goals.known
        away = [float(np.linalg.norm(q - goal.configuration)) / step for goal in goals]
        return [self._scenery.primitives_to_go(self._tool(q)), *away]

    def _tool(self, q: Array) -> Array:
        return self._parts.kinematics.forward(q)[:3, 3]
