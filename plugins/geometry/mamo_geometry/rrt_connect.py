"""RRT-Connect over the sphere kernel."""

from __future__ import annotations

import numpy as np

from mamo_core.interfaces.arm_planner import ArmPlan, ArmPlanner, ArmPlanStatus, free_goals
from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, IntArray
from mamo_geometry.arrays import ChainArrays, SphereArrays, WorldArrays
from mamo_geometry.options import RRTConnectOptions
from mamo_geometry.rrt_kernels import connect, shortcut
from mamo_geometry.sphere_checker import SphereWorld

_CLOSE = 1e-9
_MOST_NODES = 20_000


class RRTConnect(ArmPlanner):
    """Bidirectional tree search; says EXHAUSTED when its checks ran out, which proves nothing."""

    def __init__(self, arm: ArmModel, options: RRTConnectOptions) -> None:
        self._options = options
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
        if not isinstance(world, SphereWorld):
            raise TypeError(f"rrt_connect plans in worlds of 'spheres', not {type(world).__name__}")
        checks = np.zeros(1, dtype=np.int64)
        limit = self._options.max_checks if max_checks is None else max_checks
        checks[0] = 1 + len(goals)
        open_goals = free_goals(start, goals, world)
        if isinstance(open_goals, ArmPlan):
            return open_goals
        trees = _trees(start, goals[open_goals], min(limit // 2, _MOST_NODES))
        arrays = (world.chain, world.spheres, world.world)
        low = np.minimum(self._low, np.minimum(start, goals.min(axis=0)))
        high = np.maximum(self._high, np.maximum(start, goals.max(axis=0)))
        met = connect(*arrays, *trees, len(open_goals), low, high, rng, limit, checks)
        if met[0] < 0:
            return ArmPlan(ArmPlanStatus.EXHAUSTED, None, -1, int(checks[0]))
        path, root = _joined(*trees, *met)
        path = self._shortened(path, arrays, rng, checks)
        return ArmPlan(ArmPlanStatus.SOLVED, path, int(open_goals[root]), int(checks[0]))

    def _shortened(
        self,
        path: Array,
        arrays: tuple[ChainArrays, SphereArrays, WorldArrays],
        rng: np.random.Generator,
        checks: IntArray,
    ) -> Array:
        tries = self._options.shortcuts
        rows = np.zeros((2, len(path) + 2 * tries, path.shape[1]))
        rows[0, : len(path)] = path
        count, swapped = shortcut(*arrays, rows[0], rows[1], len(path), tries, rng, checks)
        short = rows[int(swapped), :count]
        moved = np.abs(np.diff(short, axis=0)).max(axis=1) > _CLOSE
        return short[np.concatenate([[True], moved])]


def _trees(start: Array, goals: Array, room: int) -> tuple[Array, IntArray]:
    """Nodes (2, n, dof) and parents (2, n) of a tree at the start and one at the goals."""
    size = room + len(goals) + 4
    nodes = np.empty((2, size, start.size))
    nodes[0, 0] = start
    nodes[1, : len(goals)] = goals
    parents = np.empty((2, size), dtype=np.int64)
    parents[:, : max(1, len(goals))] = -1
    return nodes, parents


def _joined(nodes: Array, parents: IntArray, mine: int, theirs: int) -> tuple[Array, int]:
    """The path through start-tree node ``mine`` and goal-tree node ``theirs`` (the same place).

    Also the number of the goal it ends at.
    """
    front = _to_root(parents[0], mine)
    back = _to_root(parents[1], theirs)
    return np.vstack([nodes[0, front[::-1]], nodes[1, back[1:]]]), back[-1]


def _to_root(parents: IntArray, node: int) -> list[int]:
    chain = [int(node)]
    while parents[chain[-1]] >= 0:
        chain.append(int(parents[chain[-1]]))
    return chain
