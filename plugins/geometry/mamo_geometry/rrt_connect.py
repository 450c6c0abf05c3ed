"""RRT-Connect over the sphere kernel."""

from __future__ import annotations

import numpy as np

from mamo_core.interfaces.arm_planner import ArmPlan, ArmPlanner, ArmPlanStatus
from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array
from mamo_geometry.options import RRTConnectOptions
from mamo_geometry.rrt_kernels import connect, shortcut
from mamo_geometry.sphere_checker import SphereWorld

_CLOSE = 1e-9


class RRTConnect(ArmPlanner):
    """Bidirectional tree search; says EXHAUSTED when its checks ran out, which proves nothing."""

    def __init__(self, arm: ArmModel, options: RRTConnectOptions) -> None:
        self._options = options
        self._low = np.maximum(arm.lower, arm.home - np.pi)
        self._high = np.minimum(arm.upper, arm.home + np.pi)

    def plan(
        self,
        start: Array,
        goals: Array,
        world: CollisionWorld,
        rng: np.random.Generator,
        *,
        max_checks: int | None = None,
    ) -> ArmPlan:
        if not isinstance(world, SphereWorld):
            raise TypeError(f"rrt_connect plans in worlds of 'spheres', not {type(world).__name__}")
        checks = np.zeros(1, dtype=np.int64)
        limit = self._options.max_checks if max_checks is None else max_checks
        checks[0] = 1 + len(goals)
        if not world.free(start)[0]:
            return ArmPlan(ArmPlanStatus.START_BLOCKED, None, -1, 1)
        open_goals = np.flatnonzero(world.free(goals)) if len(goals) else np.zeros(0, dtype=int)
        if not open_goals.size:
            return ArmPlan(ArmPlanStatus.GOALS_BLOCKED, None, -1, int(checks[0]))
        arrays = (world.chain, world.spheres, world.world)
        begin = np.array(start, dtype=np.float64)
        path, goal = connect(
            *arrays,
            begin,
            np.ascontiguousarray(goals[open_goals]),
            np.minimum(self._low, np.minimum(begin, goals.min(axis=0))),
            np.maximum(self._high, np.maximum(begin, goals.max(axis=0))),
            rng,
            limit,
            checks,
        )
        if goal < 0:
            return ArmPlan(ArmPlanStatus.EXHAUSTED, None, -1, int(checks[0]))
        path = shortcut(*arrays, path, self._options.shortcuts, rng, checks)
        moved = np.abs(np.diff(path, axis=0)).max(axis=1) > _CLOSE
        path = path[np.concatenate([[True], moved])]
        return ArmPlan(ArmPlanStatus.SOLVED, path, int(open_goals[goal]), int(checks[0]))
