"""Vertices and edges of the graph over rearrangements (thesis 5.4, 6.3.3)."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass, field

from mamo_core.interfaces.action_generator import ActionRequest
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array
from mamo_core.types.scene import SceneState
from mamo_planners.search.run import Actions
from mamo_planners.search.stand import Stand


@dataclass(eq=False)
class Aim:
    """An object that MAPF wants at ``goal`` (2,), world xy, by any of ``pending`` kinds of action.

    Each kind is struck off when it was tried; ``reached``: one of them worked.
    """

    name: str
    goal: Array
    pending: int
    reached: bool = False

    @property
    def failed(self) -> bool:
        """Whether no kind of action works."""
        return not self.pending and not self.reached


@dataclass(eq=False)
class Vertex:
    """A rearrangement and the actions that lead to it.

    ``known``: how many failed aims the last MAPF call was told of; ``hallucinated``: how many aims
    that did not fail. ``retrieval_tried``: whether the target cannot be taken out from here.
    ``refuted``: what was predicted to lead here does not. ``failures``: how often a kind of action
    failed for an object; ``failed``: which actions of a kind did.
    """

    number: int
    stand: Stand
    actions: Actions
    parent: Vertex | None = None
    aims: list[Aim] = field(default_factory=list)
    expansions: int = 0
    known: int = 0
    hallucinated: int = 0
    retrieval_tried: bool = False
    refuted: bool = False
    failures: Counter[tuple[str, str]] = field(default_factory=Counter)
    failed: defaultdict[str, list[RearrangementAction]] = field(
        default_factory=lambda: defaultdict(list)
    )
    _wanted: set[tuple[str, float, float]] = field(default_factory=set)

    @property
    def state(self) -> SceneState:
        """Where everything is."""
        return self.stand.state

    @property
    def depth(self) -> int:
        """Number of actions on the way."""
        return len(self.actions)

    def add_aim(self, aim: Aim) -> None:
        """MAPF wants that now."""
        self.aims.append(aim)
        self._wanted.add(_key(aim.name, aim.goal))

    def has_aim(self, name: str, goal: Array) -> bool:
        """Whether MAPF wanted exactly that before."""
        return _key(name, goal) in self._wanted


def _key(name: str, goal: Array) -> tuple[str, float, float]:
    return name, float(goal[0]), float(goal[1])


@dataclass(frozen=True, eq=False)
class Edge:
    """An action that nobody has looked at yet: ``kind`` of generator and what it is asked for."""

    number: int
    parent: Vertex
    kind: str
    request: ActionRequest
    cost: float
    aim: Aim | None = None
