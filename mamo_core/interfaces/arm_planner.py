"""Collision-free joint paths."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.types.geometry import Array, IntArray


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


def free_goals(start: Array, goals: Array, world: CollisionWorld) -> IntArray | ArmPlan:
    """Numbers (k,) of the goals (m, dof) that are free; or the plan that says why none can be met.

    It asks for 1 + m configurations.
    """
    if not world.free(start[None])[0]:
        return ArmPlan(ArmPlanStatus.START_BLOCKED, None, -1, 1)
    free = np.flatnonzero(world.free(goals)) if len(goals) else np.zeros(0, dtype=np.int64)
    if not free.size:
        return ArmPlan(ArmPlanStatus.GOALS_BLOCKED, None, -1, 1 + len(goals))
    return free
