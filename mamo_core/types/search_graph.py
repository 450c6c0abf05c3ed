"""What a search over rearrangements has looked at, as values for pictures of it."""

from __future__ import annotations

from dataclasses import dataclass

from mamo_core.types.geometry import Array
from mamo_core.types.region import SweptRegion

GRAPHS = "graphs"
"""Under this key ``Solution.info`` has the ``SearchGraph`` of every NGR, in order of time."""

KEEPS_GRAPHS = "rearrangement_graph"
"""Capability of searches that do."""


@dataclass(frozen=True, eq=False)
class GraphVertex:
    """A rearrangement: ``poses`` (n, 7) of the objects. ``predicted``: nobody has executed what
    led here."""

    poses: Array
    predicted: bool = False


@dataclass(frozen=True)
class GraphEdge:
    """An action of a ``kind`` for an object that was tried at vertex ``start``.

    ``end``: the vertex that it leads to, which may have been known before. None if it failed, for
    ``causes``, the last part of the keys of ``Statistics.causes``.
    """

    start: int
    end: int | None
    kind: str
    object_name: str
    causes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class SearchGraph:
    """Rearrangements under one NGR; the first one is the initial scene.

    Edges stand in order of time. ``solution``: the vertices on the way to where the target was
    taken out, the first one included; empty if it was not.
    """

    region: SweptRegion | None
    vertices: tuple[GraphVertex, ...]
    edges: tuple[GraphEdge, ...] = ()
    solution: tuple[int, ...] = ()
