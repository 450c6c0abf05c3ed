"""One adaptive motion primitive (thesis 3.3.3)."""

from __future__ import annotations

from dataclasses import dataclass

from mamo_core.types.geometry import Array
from mamo_planners.reaching.goals import Goal


@dataclass(frozen=True, eq=False)
class Primitive:
    """A Phase 1 valid motion along ``path`` (k, dof) to a goal.

    ``interacts``: the arm may meet movables on it, so that only an engine can tell what happens.
    """

    path: Array
    goal: Goal
    interacts: bool

    @property
    def start(self) -> Array:
        """Where it begins (dof,)."""
        return self.path[0]
