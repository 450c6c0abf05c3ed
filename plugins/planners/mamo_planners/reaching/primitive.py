"""One adaptive motion primitive (thesis 3.3.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.robots.timing import interpolated
from mamo_core.types.geometry import Array
from mamo_planners.reaching.goals import Goal

_STEP = 0.05
"""How finely the first contact on a path is looked for, rad."""


@dataclass(frozen=True, eq=False)
class Primitive:
    """A Phase 1 valid motion along ``path`` (k, dof) to a goal.

    Along ``approach`` (a, dof), its first part, the arm touches nothing; on ``sweep`` (s, dof), the
    rest, it may meet movables, so that only an engine can tell what happens; no rows if it meets
    none.
    """

    path: Array
    goal: Goal
    approach: Array
    sweep: Array

    @property
    def start(self) -> Array:
        """Where it begins (dof,)."""
        return self.path[0]

    @property
    def interacts(self) -> bool:
        """Whether it has to be simulated."""
        return len(self.sweep) > 0


def primitive_along(path: Array, goal: Goal, everything: CollisionWorld) -> Primitive:
    """The primitive along ``path``, parted where it may first touch something."""
    free = everything.edges_free(path[:-1], path[1:])
    if free.all():
        return Primitive(path, goal, path, path[:0])
    edge = int(np.argmin(free))
    fine = interpolated(path[edge : edge + 2], _STEP)
    # Where the pieces are all free, though the whole is not, the first row is the safe one.
    parting = fine[int(np.argmin(everything.edges_free(fine[:-1], fine[1:])))]
    approach = np.vstack([path[: edge + 1], parting])
    return Primitive(path, goal, approach, np.vstack([parting, path[edge + 1 :]]))
