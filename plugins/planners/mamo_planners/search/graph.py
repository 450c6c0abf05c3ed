"""The graph over rearrangements under one NGR (thesis, Algorithm 5, and 6.3)."""

from __future__ import annotations

import heapq
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import count

from mamo_core.interfaces.action_generator import ActionRequest
from mamo_core.types.geometry import Array
from mamo_core.types.region import SweptRegion
from mamo_core.types.search_graph import SearchGraph
from mamo_core.types.solution import Plan
from mamo_planners.search.abstraction import occupied
from mamo_planners.search.attempts import Attempt, causes_since, graph_of
from mamo_planners.search.goals import Failure, GoalMemory, GoalPenalties
from mamo_planners.search.likeness import alike
from mamo_planners.search.orders import Key, Order
from mamo_planners.search.push_database import PushDatabase
from mamo_planners.search.run import Actions, SearchRun
from mamo_planners.search.stand import Stand
from mamo_planners.search.vertices import Aim, Edge, Vertex

_REUSED = "push"
"""Kind of action that the database keeps."""


@dataclass(frozen=True)
class GraphRules:
    """How a graph grows.

    ``lazy``: edges are evaluated when they come first in the queue, not when they are found.
    ``costs`` by kind of action, 1 unless given: which of equally deep edges comes first.
    ``patience`` by kind of action: failures for an object at a vertex before it is left out there.
    ``agnostic``: requests without a path made at a vertex that MAPF has no more ideas for.
    ``expansions``: of a vertex, and ``visits``: in all, before it or the graph is left.
    ``max_actions``: on the way to a vertex.
    """

    lazy: bool
    memory: GoalMemory
    costs: Mapping[str, float]
    patience: Mapping[str, int]
    agnostic: int
    expansions: int
    visits: int
    max_actions: int


class RearrangementGraph:
    """OPEN with its vertices and waiting edges; without ``database`` nothing is used again."""

    def __init__(
        self,
        run: SearchRun,
        region: SweptRegion,
        order: Order,
        rules: GraphRules,
        database: PushDatabase | None,
        failures: list[Failure],
    ) -> None:
        """``failures``: what is known from other graphs; this one adds its own."""
        self._run, self._region, self._order, self._rules = run, region, order, rules
        self._database, self._failures = database, failures
        self._penalties = GoalPenalties(run.parts.problem.scene, rules.memory)
        self._numbers = count()
        self._open: list[tuple[Key, int, Vertex | Edge]] = []
        self._vertices: list[Vertex] = []
        self._attempts: list[Attempt] = []
        self._goal: Vertex | None = None

    @property
    def vertices(self) -> tuple[Vertex, ...]:
        """All rearrangements, in the order they were found."""
        return tuple(self._vertices)

    @property
    def record(self) -> SearchGraph:
        """All that was looked at."""
        return graph_of(self._region, self._vertices, self._attempts, self._goal)

    def search(self, root: Stand) -> Plan | None:
        """A verified plan, or None when nothing is left to do here or the work is up.

        That the target cannot be taken out at the root is known.
        """
        self._insert(root, (), None)
        visits = 0
        while self._open and visits < self._rules.visits and not self._run.budget.exhausted:
            _, _, first = heapq.heappop(self._open)
            if isinstance(first, Edge):
                self._evaluate(first)
                continue
            visits += 1
            plan = self._visit(first)
            if plan is not None:
                self._goal = first
                return plan
        return None

    def _visit(self, vertex: Vertex) -> Plan | None:
        """Try to retrieve from here, otherwise expand."""
        if vertex.stand.predicted and not self._confirm(vertex):
            return None
        if not vertex.retrieval_tried:
            vertex.retrieval_tried = True
            plan = self._run.retrieve(vertex.stand, vertex.actions, self._region)
            if plan is not None:
                return plan
        if vertex.depth < self._rules.max_actions:
            if self._expand(vertex):
                self._push(self._order.vertex(vertex), vertex)
            else:
                self._guess(vertex)
        return None

    def _confirm(self, vertex: Vertex) -> bool:
        """Execute an action that was taken from the database."""
        assert vertex.parent is not None, "the root is not predicted"
        if self._known(vertex.stand) is not None:
            return False
        stand = self._run.execution.executed(vertex.parent.stand, vertex.actions[-1], None)
        if stand is None:
            self._run.statistics.counts["database_refuted"] += 1
            vertex.refuted = True
            return False
        vertex.stand = stand
        return True

    def _expand(self, vertex: Vertex) -> bool:
        """Ask MAPF; False if the vertex is closed because there is no other way to rearrange."""
        if vertex.expansions >= self._rules.expansions:
            return False
        penalties = self._penalties.of(vertex, self._failures)
        if penalties is None:
            return False
        vertex.expansions += 1
        self._run.statistics.counts["expansions"] += 1
        paths = self._run.paths(vertex.state, self._region, penalties)
        self._tell(vertex, len(paths))
        for name in self._run.rng.permutation(sorted(paths)):
            if not vertex.has_aim(str(name), paths[str(name)][-1]):
                self._grow(vertex, str(name), paths[str(name)])
        return bool(paths)

    def _guess(self, vertex: Vertex) -> None:
        """Edges for whatever lessens the overlap with the region, without a path."""
        inside = occupied(self._run.parts.problem, vertex.state, self._region)
        for number in range(self._rules.agnostic if inside else 0):
            self._grow(vertex, inside[number % len(inside)], None)

    def _grow(self, vertex: Vertex, name: str, path: Array | None) -> None:
        """An edge for each kind of action."""
        kinds = [kind for kind, _ in self._run.parts.actions]
        aim = None
        if path is not None:
            aim = Aim(name, path[-1], len(kinds))
            vertex.add_aim(aim)
        request = ActionRequest(name, path, self._region)
        for kind in kinds:
            cost = self._rules.costs.get(kind, 1.0)
            edge = Edge(next(self._numbers), vertex, kind, request, cost, aim)
            if self._rules.lazy:
                self._push(self._order.edge(edge), edge)
            elif not self._run.budget.exhausted:
                self._evaluate(edge)

    def _evaluate(self, edge: Edge) -> None:
        """Insert where the action leads, or learn that it fails."""
        what = edge.kind, edge.request.object_name
        hopeless = edge.parent.failures[what] >= self._rules.patience.get(edge.kind, sys.maxsize)
        causes = self._run.statistics.causes
        before = dict(causes)
        found = None if hopeless else self._reused(edge) or self._realised(edge)
        if found is not None:
            end = self._insert(found[1], found[0], edge.parent)
            self._attempts.append(Attempt(edge, end, ()))
        else:
            edge.parent.failures[what] += 1
            if not hopeless:
                self._attempts.append(Attempt(edge, None, causes_since(before, causes, edge)))
        if edge.aim is None:
            return
        edge.aim.pending -= 1
        edge.aim.reached |= found is not None
        if edge.aim.failed:
            place = self._run.parts.problem.scene.index(edge.aim.name)
            start = edge.parent.state.object_poses[place, :2]
            self._failures.append(Failure(edge.aim.name, start, edge.aim.goal))

    def _realised(self, edge: Edge) -> tuple[Actions, Stand] | None:
        run, vertex, request = self._run, edge.parent, edge.request
        accept = run.lessens(self._region, vertex.state) if request.path is None else None
        failed = vertex.failed[edge.kind]
        found = run.realise(vertex.stand, edge.kind, request, accept, failed)
        if found is None:
            return None
        action, stand = found
        if self._database is not None and edge.kind == _REUSED and request.path is not None:
            self._database.add(action, request.path, vertex.state, stand.state)
        return (*vertex.actions, action), stand

    def _reused(self, edge: Edge) -> tuple[Actions, Stand] | None:
        """What a push that was valid elsewhere does here; it is executed when its turn comes."""
        vertex, request, run = edge.parent, edge.request, self._run
        if self._database is None or edge.kind != _REUSED or request.path is None:
            return None
        stored = self._database.find(request.object_name, request.path, vertex.state)
        if stored is None:
            return None
        motion = run.execution.approached_anew(vertex.stand, stored.action.motion, run.rng)
        if motion is None:
            return None
        run.statistics.counts["database_hits"] += 1
        after = vertex.stand.believed(self._database.outcome(stored, vertex.state))
        return (*vertex.actions, replace(stored.action, motion=motion)), after

    def _insert(self, stand: Stand, actions: Actions, parent: Vertex | None) -> Vertex:
        """A new vertex, or the one with this rearrangement if it is known."""
        known = self._known(stand)
        if known is not None:
            return known
        vertex = Vertex(next(self._numbers), stand, actions, parent)
        # That the target cannot be taken out at the root is known.
        vertex.retrieval_tried = parent is None
        self._vertices.append(vertex)
        self._push(self._order.vertex(vertex), vertex)
        return vertex

    def _known(self, stand: Stand) -> Vertex | None:
        """The vertex to which something that was executed has led; a prediction may be wrong."""
        scene, poses = self._run.parts.problem.scene, stand.state.object_poses
        same = (
            other
            for other in self._vertices
            if not other.stand.predicted and alike(scene, poses, other.state.object_poses).all()
        )
        known = next(same, None)
        self._run.statistics.counts["duplicates"] += known is not None
        return known

    def _push(self, key: Key, item: Vertex | Edge) -> None:
        heapq.heappush(self._open, (key, item.number, item))

    def _tell(self, vertex: Vertex, moving: int) -> None:
        self._run.progress(
            f"{len(self._vertices)} rearrangements, {vertex.depth} actions, "
            f"{moving} objects in the way"
        )
