"""Collision-free joint paths."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.types.geometry import Array


class ArmPlanStatus(StrEnum):
    """How a query ended; EXHAUSTED is no proof that there is no path."""

    SOLVED = "solved"
    START_BLOCKED = "start_blocked"
    GOALS_BLOCKED = "goals_blocked"
    EXHAUSTED = "exhausted"


@dataclass(frozen=True, eq=False)
class ArmPlan:
    """``path`` (k, dof) from the start to goal ``goal``; ``checks``: configurations tested."""

    status: ArmPlanStatus
    path: Array | None
    goal: int
    checks: int


class ArmPlanner(ABC):
    """Plans for the arm of one problem."""

    @abstractmethod
    def plan(
        self,
        start: Array,
        goals: Array,
        world: CollisionWorld,
        rng: np.random.Generator,
        *,
        max_checks: int | None = None,
    ) -> ArmPlan:
        """A path from ``start`` (dof,) to any of ``goals`` (m, dof), within ``max_checks``."""
