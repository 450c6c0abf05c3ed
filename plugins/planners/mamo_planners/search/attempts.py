"""Keeps what a graph has tried, for pictures of the search; it changes nothing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import SceneState
from mamo_core.types.search_graph import GraphEdge, GraphVertex, SearchGraph
from mamo_planners.search.vertices import Edge, Vertex

_REFUTED = ("not_reproduced",)


@dataclass(frozen=True, eq=False)
class Attempt:
    """An edge that was evaluated, and the vertex at its ``end``, or why there is none."""

    edge: Edge
    end: Vertex | None
    causes: tuple[str, ...]


def causes_since(before: Mapping[str, int], causes: Counter[str], edge: Edge) -> tuple[str, ...]:
    """Why the action failed: what was counted for it since ``before``, the most frequent first."""
    prefix = f"{edge.request.object_name}/{edge.kind}/"
    new = {
        key.removeprefix(prefix): times - before.get(key, 0)
        for key, times in causes.items()
        if key.startswith(prefix) and times > before.get(key, 0)
    }
    return tuple(sorted(new, key=lambda cause: (-new[cause], cause)))


def graph_of(
    region: SweptRegion,
    vertices: Sequence[Vertex],
    attempts: Sequence[Attempt],
    goal: Vertex | None,
) -> SearchGraph:
    """The graph as values; ``goal``: where the target was taken out.

    An action that the database promised and the engine refuted has failed, and leads nowhere.
    """
    real = [vertex for vertex in vertices if not vertex.refuted]
    number = {vertex: place for place, vertex in enumerate(real)}
    edges = tuple(
        GraphEdge(
            number[attempt.edge.parent],
            number.get(attempt.end) if attempt.end is not None else None,
            attempt.edge.kind,
            attempt.edge.request.object_name,
            _REFUTED if attempt.end is not None and attempt.end.refuted else attempt.causes,
        )
        for attempt in attempts
    )
    return SearchGraph(
        region,
        tuple(GraphVertex(v.state.object_poses, v.stand.predicted) for v in real),
        edges,
        tuple(number[vertex] for vertex in _way_to(goal)),
    )


def at_once(initial: SceneState) -> SearchGraph:
    """The graph of a search that took the target out of the initial scene."""
    return SearchGraph(None, (GraphVertex(initial.object_poses),), (), (0,))


def _way_to(vertex: Vertex | None) -> list[Vertex]:
    way: list[Vertex] = []
    while vertex is not None:
        way.insert(0, vertex)
        vertex = vertex.parent
    return way
