"""Adaptive motion primitives: straight joint motions to a goal from nearby (thesis 3.3.3)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array
from mamo_planners.reaching.distance_field import DistanceField
from mamo_planners.reaching.goals import Goal, Goals
from mamo_planners.reaching.primitive import Primitive, primitive_along
from mamo_planners.reaching.promising import Promising

Rounding = Callable[[Array], Array]
"""Moves a configuration (dof,) to the nearest that the search can get to."""

_TRIES = 240
_LARGEST_TURN = 0.6
_VARIATION = 0.1
"""Standard deviation of what joints are varied by, rad."""
_SAME_GOAL = 0.5


@dataclass(frozen=True)
class Mix:
    """Shares of the primitives drawn: those that bend; those that vary one that held long."""

    via: float = 0.0
    vary: float = 0.0


class Primitives:
    """Makes primitives in one problem.

    ``fixed``: what must not be touched; ``everything``: all objects at their initial poses;
    ``promising``: what may be varied.
    """

    def __init__(
        self,
        arm: ArmModel,
        kinematics: Kinematics,
        goals: Goals,
        fixed: CollisionWorld,
        everything: CollisionWorld,
        field: DistanceField,
        promising: Promising,
        delta: float,
    ) -> None:
        self._arm, self._kinematics, self._goals = arm, kinematics, goals
        self._fixed, self._everything = fixed, everything
        self._field, self._promising, self.delta = field, promising, delta
        """``delta``: how close to a goal primitives begin, m."""

    def begins_at(self, q: Array) -> bool:
        """Whether the tool is close enough to a goal, around what is fixed."""
        return self._field.distance(self._kinematics.forward(q)[:3, 3]) <= self.delta

    def to_goal(self, q: Array, rng: np.random.Generator) -> Primitive | None:
        """The primitive from ``q`` (dof,), if it is Phase 1 valid (Definition 1)."""
        goal = self._goals.near(q, rng)
        return self._valid(np.stack([q, goal.configuration]), goal)

    def drawn(self, rng: np.random.Generator, rounded: Rounding, mix: Mix) -> Iterator[Primitive]:
        """Random primitives whose start touches nothing, for as long as tries yield some."""
        for _ in range(_TRIES):
            model = self._promising.drawn(rng) if _chance(mix.vary, rng) else None
            if model is not None:
                primitive = self._varied(model, rounded, rng)
            else:
                primitive = self._random(rounded, mix.via, rng)
            if primitive is not None:
                yield primitive

    def _random(self, rounded: Rounding, via: float, rng: np.random.Generator) -> Primitive | None:
        for q in map(rounded, self._nearby(rng)):
            if self._may_begin(q):
                return self._bent(q, rng) if _chance(via, rng) else self.to_goal(q, rng)
        return None

    def _varied(
        self, model: Primitive, rounded: Rounding, rng: np.random.Generator
    ) -> Primitive | None:
        """A primitive like another one, with a bend."""
        path = model.path
        middle = path[1] if len(path) > 2 else path[0] + rng.random() * (path[1] - path[0])
        start, middle = (q + rng.normal(scale=_VARIATION, size=q.shape) for q in (path[0], middle))
        start, middle = rounded(start), np.clip(middle, self._arm.lower, self._arm.upper)
        if not self._may_begin(start):
            return None
        goal = model.goal if _chance(_SAME_GOAL, rng) else self._goals.near(middle, rng)
        return self._valid(np.stack([start, middle, goal.configuration]), goal)

    def _may_begin(self, q: Array) -> bool:
        return self.begins_at(q) and bool(self._everything.free(q)[0])

    def _bent(self, q: Array, rng: np.random.Generator) -> Primitive | None:
        """A primitive from ``q`` by a configuration that may be among movables."""
        for middle in self._nearby(rng, q):
            goal = self._goals.near(middle, rng)
            return self._valid(np.stack([q, middle, goal.configuration]), goal)
        return None

    def _nearby(self, rng: np.random.Generator, near: Array | None = None) -> Array:
        """A random configuration (k <= 1, dof) with the tool around a goal."""
        tool = self._goals.tools[int(rng.integers(len(self._goals.tools)))]
        T = _moved(tool, self.delta, rng)
        return self._kinematics.inverse(T, rng, count=1, near=near)

    def _valid(self, path: Array, goal: Goal) -> Primitive | None:
        if not self._fixed.edges_free(path[:-1], path[1:]).all():
            return None
        return primitive_along(path, goal, self._everything)


def _chance(share: float, rng: np.random.Generator) -> bool:
    return share > 0.0 and rng.random() < share


def _moved(T: Array, delta: float, rng: np.random.Generator) -> Array:
    """A tool pose in the ball around ``T`` (4, 4), turned a little."""
    way = rng.normal(size=3)
    turn = rng.normal(size=3)
    angle = rng.uniform(0.0, _LARGEST_TURN)
    moved = T.copy()
    moved[:3, 3] += delta * rng.random() ** (1 / 3) * way / np.linalg.norm(way)
    moved[:3, :3] = _rotation(turn / np.linalg.norm(turn), angle) @ T[:3, :3]
    return moved


def _rotation(axis: Array, angle: float) -> Array:
    """Rotation (3, 3) about a unit axis (Rodrigues)."""
    K = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * (K @ K)
