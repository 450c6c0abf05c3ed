"""A problem made ready for the searches: pair tables at once, an agent's maps when first needed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from mamo_core.types.geometry import Array, BoolArray
from mamo_core.types.mapf import GoalPenalty, MAPFAgent, MAPFProblem
from mamo_planners.mapf.distance import FAR, Int64Array, uniform_distance, weighted_distance
from mamo_planners.mapf.footprint import footprint_of, grown, pack
from mamo_planners.mapf.maps import add_penalty, cells_inside, free_cells, starts_inside
from mamo_planners.mapf.tables import TOUCH, PairTables, build_pair_tables

UNIT = 1000
"""Integer units of one lattice step: costs are kept to a thousandth of a step."""

MOST = 500_000 * UNIT
"""Cap on penalties, so that keys fit their bits; a lower bound stays one."""


class AgentMap(NamedTuple):
    """One agent's lattice; arrays (nx, ny) over the steps ``first`` (2,) + [0, n) from its start.

    ``goal``: units paid for ending there after a move (``FAR``: not a goal). ``step``: units of
    arriving by a move. ``distance``: units to the cheapest goal past the obstacles.
    """

    first: Int64Array
    free: BoolArray
    goal: Int64Array
    step: Int64Array
    distance: Int64Array


class Model:
    """The problem in lattice terms; arrays are per agent, in the problem's order."""

    def __init__(self, problem: MAPFProblem) -> None:
        self.problem = problem
        self.count = len(problem.agents)
        self.footprints = [footprint_of(a.shape, a.pose) for a in problem.agents]
        self.shapes = pack(self.footprints, [a.pose[:2] for a in problem.agents])
        self.obstacles = pack(
            [footprint_of(o.shape, o.pose) for o in problem.obstacles],
            [o.pose[:2] for o in problem.obstacles],
        )
        self.wait_units = max(1, round(problem.wait_cost * UNIT))
        self.tables: PairTables = build_pair_tables(self.shapes, problem.resolution, problem.margin)
        self.stay_units = self._stay_units()
        self._maps: dict[int, AgentMap] = {}

    def map(self, agent: int) -> AgentMap:
        """The agent's maps, built on first use."""
        if agent not in self._maps:
            self._maps[agent] = build_map(self, agent)
        return self._maps[agent]

    def _stay_units(self) -> Int64Array:
        """Units (n,) of never moving: penalties at the start, ``FAR`` where it must move.

        The goal bounds and the goal margin are for goals that a push has to hit; an object that
        stays put needs only to be outside the region itself.
        """
        region = self.problem.region
        inside = starts_inside(self.shapes, region.origin, region.resolution, region.lowest)
        units = np.where(inside, FAR, 0).astype(np.int64)
        for i, agent in enumerate(self.problem.agents):
            for penalty in agent.penalties:
                gap = np.hypot(*(agent.pose[:2] - penalty.position))
                if units[i] < FAR and gap <= penalty.radius + TOUCH:
                    cost = penalty_units(penalty)
                    units[i] = FAR if cost >= FAR else min(units[i] + cost, MOST)
        return units


def penalty_units(penalty: GoalPenalty) -> int:
    """A penalty's cost in units; ``FAR`` where it forbids."""
    return int(FAR) if np.isinf(penalty.cost) else min(int(penalty.cost * UNIT + 1e-6), MOST)


def build_map(model: Model, index: int) -> AgentMap:
    """The maps of one agent."""
    problem = model.problem
    agent = problem.agents[index]
    step = problem.resolution
    outline = model.footprints[index]
    extent = np.stack([outline.lower(), outline.upper()]) + agent.pose[:2]
    # An agent that starts beyond a bound may stay as far out as it is, and no farther.
    lower = np.minimum(problem.transit_lower, extent[0])
    upper = np.maximum(problem.transit_upper, extent[1])
    first, size = _lattice_within(extent, lower, upper, step)
    free = free_cells(index, model.shapes, model.obstacles, problem.margin, first, size, step)
    goal = _goal_map(model, index, first, size, free)
    if agent.cost_field is None:
        cost = np.full(free.shape, UNIT, dtype=np.int64)
        return AgentMap(first, free, goal, cost, uniform_distance(free, goal, UNIT))
    cost = _step_units(agent, first, size, step)
    return AgentMap(first, free, goal, cost, weighted_distance(free, goal, cost))


def _lattice_within(
    extent: Array, lower: Array, upper: Array, step: float
) -> tuple[Int64Array, Int64Array]:
    """First lattice step (2,) and counts (2,) that keep ``extent`` (2, 2) within the bounds."""
    first = np.ceil((lower - extent[0] - TOUCH) / step).astype(np.int64)
    last = np.floor((upper - extent[1] + TOUCH) / step).astype(np.int64)
    return first, last - first + 1


def _goal_map(
    model: Model, index: int, first: Int64Array, size: Int64Array, free: BoolArray
) -> Int64Array:
    problem = model.problem
    agent = problem.agents[index]
    region = problem.region
    step = problem.resolution
    outline = model.footprints[index]
    wide = footprint_of(grown(agent.shape, problem.goal_margin), agent.pose)
    inside = cells_inside(
        agent.pose[:2],
        wide.points,
        wide.radius,
        wide.top,
        region.origin,
        region.resolution,
        region.lowest,
        first,
        size,
        step,
    )
    extent = np.stack([outline.lower(), outline.upper()]) + agent.pose[:2]
    begin, count = _lattice_within(extent, problem.goal_lower, problem.goal_upper, step)
    low = np.clip(begin - first, 0, size)
    high = np.clip(begin + count - first, 0, size)
    within = slice(low[0], high[0]), slice(low[1], high[1])
    goal = np.full(free.shape, FAR)
    goal[within][free[within] & ~inside[within]] = 0
    for penalty in agent.penalties:
        dx, dy = penalty.position - agent.pose[:2]
        units = penalty_units(penalty)
        add_penalty(goal, dx, dy, penalty.radius, units, MOST, first, step)
    return goal


def _step_units(agent: MAPFAgent, first: Int64Array, size: Int64Array, step: float) -> Int64Array:
    field = agent.cost_field
    assert field is not None
    x, y = (
        np.floor(
            (agent.pose[k] + (first[k] + np.arange(size[k])) * step - field.origin[k])
            / field.resolution
            + TOUCH
        ).astype(np.int64)
        for k in range(2)
    )
    nx, ny = field.values.shape
    within = ((x >= 0) & (x < nx))[:, None] & ((y >= 0) & (y < ny))[None, :]
    values: npt.NDArray[np.float64] = field.values[
        np.clip(x, 0, nx - 1)[:, None], np.clip(y, 0, ny - 1)[None, :]
    ]
    extra = np.minimum(np.where(within, values, 0.0) * UNIT + 1e-6, MOST)
    return UNIT + extra.astype(np.int64)
