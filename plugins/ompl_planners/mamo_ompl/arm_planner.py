"""The planners of OMPL behind our interface."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from mamo_core.interfaces.arm_planner import ArmPlan, ArmPlanner, ArmPlanStatus, free_goals
from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array
from mamo_ompl.kinds import Kind
from mamo_ompl.options import OmplOptions
from mamo_ompl.query import quiet, solve
from mamo_ompl.shortcuts import shortened
from mamo_ompl.work import Work

_CLOSE = 1e-9
_SEEDS = 2**31


class OmplArmPlanner(ArmPlanner):
    """A planner of OMPL over the worlds of any checker; EXHAUSTED proves nothing.

    Checks count configurations; a motion counts as many as its length says (``work.EDGE_STEP``),
    whatever the checker looked at. The solve may go over its limit by the motion under way, and
    shortcuts come on top, as with ``rrt_connect``. Not for several threads at a time.
    """

    def __init__(self, arm: ArmModel, kind: Kind, options: OmplOptions) -> None:
        quiet()
        self._kind, self._options = kind, options
        self._low, self._high = arm.around_home

    def plan(
        self,
        start: Array,
        goals: Array,
        world: CollisionWorld,
        rng: np.random.Generator,
        *,
        max_checks: int | None = None,
    ) -> ArmPlan:
        limit = self._options.max_checks if max_checks is None else max_checks
        usable = free_goals(start, goals, world)
        if isinstance(usable, ArmPlan):
            return usable
        work = Work(world, limit, spent=1 + len(goals))
        path = self._path(start, goals[usable], work, rng)
        if path is None:
            return ArmPlan(ArmPlanStatus.EXHAUSTED, None, -1, work.checks)
        goal = int(usable[_nearest(path[-1], goals[usable])])
        return ArmPlan(ArmPlanStatus.SOLVED, path, goal, work.checks)

    def _path(
        self, start: Array, goals: Array, work: Work, rng: np.random.Generator
    ) -> Array | None:
        """A path that our checker confirms motion by motion, or None."""
        if np.abs(goals - start).max(axis=1).min() <= _CLOSE:
            return start[None].copy()
        path = solve(
            self._kind.planner,
            lambda made: self._kind.set_up(made, self._options),
            start,
            goals,
            self._bounds(start, goals),
            work,
            int(rng.integers(1, _SEEDS)),
            getattr(self._options, "optimize", False),
        )
        if path is None:
            return None
        work.unlimited()
        path = _without_repetitions(shortened(path, work, rng, self._options.shortcuts))
        confirmed = _confirmed(path, work)
        work.finish()
        return path if confirmed else None

    def _bounds(self, start: Array, goals: Array) -> tuple[Array, Array]:
        """Half a turn around home, and further where start or goals are further."""
        low = np.minimum(self._low, np.minimum(start, goals.min(axis=0)))
        high = np.maximum(self._high, np.maximum(start, goals.max(axis=0)))
        return low, high


def _confirmed(path: Array, work: Work) -> bool:
    """Whether every motion is free, asked forwards or backwards.

    Checkers step along a motion from its start, so that the answers may differ where it is tight;
    either is sound, and OMPL asks as its trees grow.
    """
    return all(work.edge_free(a, b) or work.edge_free(b, a) for a, b in pairwise(path))


def _nearest(end: Array, goals: Array) -> int:
    return int(np.argmin(np.abs(goals - end).max(axis=1)))


def _without_repetitions(path: Array) -> Array:
    moved = np.abs(np.diff(path, axis=0)).max(axis=1) > _CLOSE
    return path[np.concatenate([[True], moved])]
