"""What OMPL asks the collision checker, counted."""

from __future__ import annotations

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.types.geometry import Array

EDGE_STEP = 0.05
"""A motion counts as one check for each so many radians of the joint that turns most."""


class Work:
    """A world that counts what it is asked, and keeps what goes wrong while OMPL runs.

    When the checks are used up nothing is free any more: OMPL's planners look at the work only
    between steps of their own, which may ask thousands of questions.

    Exceptions are kept and not raised: they would unwind through OMPL's own code, which is not
    written for that. From then on nothing is free, the work is over, and ``finish`` raises.
    """

    def __init__(self, world: CollisionWorld, limit: int, spent: int = 0) -> None:
        self._world = world
        self._limit: int | None = limit
        self._error: BaseException | None = None
        self.checks = spent

    @property
    def over(self) -> bool:
        """Whether the checks are used up, or something went wrong."""
        used_up = self._limit is not None and self.checks >= self._limit
        return used_up or self._error is not None

    def unlimited(self) -> None:
        """Answer again, however much was asked: for what comes after the search."""
        self._limit = None

    def free(self, configuration: Array) -> bool:
        """Whether a configuration (dof,) is free: one check."""
        if self.over:
            return False
        self.checks += 1
        try:
            return bool(self._world.free(configuration[None])[0])
        except BaseException as error:
            self._error = error
            return False

    def edge_free(self, start: Array, end: Array) -> bool:
        """Whether the straight joint motion between configurations (dof,) is free."""
        if self.over:
            return False
        self.checks += 1 + int(np.abs(end - start).max() / EDGE_STEP)
        try:
            return bool(self._world.edges_free(start[None], end[None])[0])
        except BaseException as error:
            self._error = error
            return False

    def finish(self) -> None:
        """Raise what went wrong, if anything did."""
        if self._error is not None:
            # Its traceback holds what OMPL holds, and OMPL holds this: let go, or nothing is freed.
            error, self._error = self._error, None
            try:
                raise error
            finally:
                del error
