"""Which vertex is expanded, or which waiting edge evaluated next: smaller keys first."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import partial

from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_planners.search.features import Features, features_of
from mamo_planners.search.options import BestFirstOptions
from mamo_planners.search.priority import PriorityModel, log_density, log_survival
from mamo_planners.search.stand import Stand
from mamo_planners.search.vertices import Edge, Vertex

Key = tuple[float, ...]
Score = Callable[[Features], tuple[float, ...]]
"""How hard a rearrangement is to solve: smaller first."""


class Order(ABC):
    """Of vertices and waiting edges, under one NGR."""

    @abstractmethod
    def vertex(self, vertex: Vertex) -> Key:
        """The key of a vertex; it changes with every expansion."""

    @abstractmethod
    def edge(self, edge: Edge) -> Key:
        """The key of an edge that waits; it comes before its parent is expanded again."""


MakeOrder = Callable[[Problem, SweptRegion], Order]


class DepthFirst(Order):
    """More actions, then cheaper ones, then fewer expansions (thesis 6.3.2, 6.3.3)."""

    def vertex(self, vertex: Vertex) -> Key:
        return (-vertex.depth, 0.0, vertex.expansions)

    def edge(self, edge: Edge) -> Key:
        return (-edge.parent.depth - 1, edge.cost, edge.parent.expansions)


class BreadthFirst(Order):
    """Fewer actions, then fewer expansions: for gathering data (thesis 5.5.3)."""

    def vertex(self, vertex: Vertex) -> Key:
        return (vertex.depth, vertex.expansions)

    def edge(self, edge: Edge) -> Key:
        return (edge.parent.depth, edge.parent.expansions - 0.5, edge.cost)


class BestFirst(Order):
    """The rearrangement that looks most like leading to a plan (thesis 5.5.3, 5.6.2)."""

    def __init__(self, problem: Problem, region: SweptRegion, score: Score) -> None:
        self._problem, self._region, self._score = problem, region, score
        self._known: dict[Stand, Key] = {}

    def vertex(self, vertex: Vertex) -> Key:
        return (*self._of(vertex), vertex.expansions)

    def edge(self, edge: Edge) -> Key:
        return (*self._of(edge.parent), edge.parent.expansions - 0.5, edge.cost)

    def _of(self, vertex: Vertex) -> Key:
        if vertex.stand not in self._known:
            found = features_of(self._problem, vertex.state, self._region)
            self._known[vertex.stand] = self._score(found)
        return self._known[vertex.stand]


def order_of(options: BestFirstOptions) -> MakeOrder:
    """What the options of a best-first search ask for."""
    if options.order == "breadth_first":
        return lambda problem, region: BreadthFirst()
    if options.order == "tiebreak":
        return partial(BestFirst, score=tiebreak)
    model = PriorityModel(options.alpha, options.beta, options.count_rate, options.effort_rate)
    log = log_density if options.density == "thesis" else log_survival
    return partial(BestFirst, score=lambda features: (-log(model, features),))


def tiebreak(features: Features) -> Key:
    """The features themselves, one after the other (thesis 5.6.2)."""
    return features.occupied, float(features.count), sum(features.efforts)
