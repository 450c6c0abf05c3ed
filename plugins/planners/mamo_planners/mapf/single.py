"""Plans for one agent at a time, with the work space and the count of work in one place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mamo_planners.mapf.constraints import Forbidden, last_time
from mamo_planners.mapf.distance import FAR, Int64Array
from mamo_planners.mapf.low_level import (
    FOUND,
    MAX_NODES,
    NO_PATH,
    OUT_OF_ROOM,
    Others,
    Query,
    Workspace,
    plan,
    struck,
    trace,
)
from mamo_planners.mapf.model import Model
from mamo_planners.mapf.tables import Int32Array


class WorkOutError(Exception):
    """The budget of expansions is used up."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A path (T + 1, 2) in lattice steps; ``cost`` and ``bound`` (on the cheapest) in units."""

    path: Int32Array
    cost: int
    bound: int


class SinglePlanner:
    """Low-level searches on one model; ``expansions`` used and ``limit`` allowed, in all."""

    def __init__(self, model: Model, limit: int, workspace: Workspace | None = None) -> None:
        self.model = model
        self.limit = limit
        self.expansions = 0
        # Small at first: touching new memory costs more than most searches do.
        self.workspace = workspace if workspace is not None else _workspace(1 << 12, 0, 0)

    def plan(
        self,
        agent: int,
        rows: Int32Array,
        others: Others,
        weight: float = 1.0,
        allowance: int = 0,
    ) -> Plan | None:
        """A path under the constraint rows (c, 9), or None if there is none.

        Raises:
            WorkOutError: the expansions allowed are used up.
        """
        free = len(rows) == 0 and self.model.stay_units[agent] == 0
        if free and not struck(agent, others, self.model.tables):
            return Plan(np.zeros((1, 2), dtype=np.int32), 0, 0)
        grid = self.model.map(agent)
        horizon = last_time(rows)
        if weight > 1.0 or allowance > 0 or others.hard.any():
            horizon = max(horizon, int(others.lengths.max()))
        while True:
            self._fit(horizon, grid.free.size)
            query = Query(
                agent,
                int(self.model.stay_units[agent]),
                self.model.wait_units,
                horizon,
                float(weight),
                int(allowance),
                self.limit - self.expansions,
            )
            outcome, node, cost, bound, used = plan(
                query, grid, rows, others, self.model.tables, self.workspace
            )
            self.expansions += used
            if outcome != OUT_OF_ROOM or len(self.workspace.nodes) >= MAX_NODES:
                break
            self.workspace = _workspace(4 * len(self.workspace.nodes), *self.workspace.best.shape)
        if outcome == FOUND:
            return Plan(trace(node, self.workspace.nodes, grid), cost, bound)
        if outcome == NO_PATH:
            return None
        raise WorkOutError

    def _fit(self, horizon: int, cells: int) -> None:
        rows = 2 * (horizon + 1)
        have = self.workspace.best.shape
        if rows > have[0] or cells > have[1]:
            shape = max(2 * rows, have[0]), max(cells + cells // 8, have[1])
            self.workspace = _workspace(len(self.workspace.nodes), *shape)


def _workspace(nodes: int, layers: int, cells: int) -> Workspace:
    nodes = min(nodes, MAX_NODES)
    return Workspace(
        np.empty((nodes, 7), dtype=np.int64),
        np.empty((3, nodes), dtype=np.int64),
        np.zeros(6, dtype=np.int64),
        np.zeros((layers, cells), dtype=np.int64),
        np.zeros(1, dtype=np.int64),
        Forbidden(
            np.zeros((layers // 2, cells), dtype=np.int32),
            np.zeros(cells, dtype=np.int32),
            np.zeros(cells, dtype=np.int32),
        ),
    )


def nowhere(model: Model, agent: int) -> str | None:
    """Why the agent can never be rid of the region, whatever the others do; None if it can."""
    if model.stay_units[agent] < FAR:
        return None
    grid = model.map(agent)
    start = tuple(-grid.first)
    if grid.distance[start] < FAR:
        return None
    if (grid.goal >= FAR).all():
        return "no position within the goal bounds is outside the region and not forbidden"
    return "no position outside the region can be reached past the obstacles and bounds"


def no_others(count: int) -> Others:
    """No paths known yet."""
    return Others(
        np.zeros((count, 1, 2), dtype=np.int32),
        np.zeros(count, dtype=np.int64),
        np.zeros(count, dtype=np.bool_),
    )


def with_path(others: Others, agent: int, path: Int32Array) -> Others:
    """The same with ``agent``'s path set; nothing is changed in place."""
    longest = max(others.paths.shape[1], len(path))
    paths = np.zeros((len(others.lengths), longest, 2), dtype=np.int32)
    paths[:, : others.paths.shape[1]] = others.paths
    paths[agent, : len(path)] = path
    lengths: Int64Array = others.lengths.copy()
    lengths[agent] = len(path)
    return Others(paths, lengths, others.hard)
