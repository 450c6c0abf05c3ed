"""Prioritised planning: one agent after another, each past those before it, in random orders.

Fast and incomplete; a failed order is tried again with another one from the generator.
"""

from __future__ import annotations

import numpy as np

from mamo_planners.mapf.conflict_search import Outcome
from mamo_planners.mapf.conflicts import find_conflicts
from mamo_planners.mapf.constraints import NONE
from mamo_planners.mapf.low_level import Others
from mamo_planners.mapf.model import Model
from mamo_planners.mapf.single import Plan, SinglePlanner, WorkOutError, no_others, with_path


def prioritized(
    model: Model, planner: SinglePlanner, rng: np.random.Generator, orders: int
) -> Outcome:
    """The first solution of up to ``orders`` orders; the bound is the sum of lone plans."""
    others = no_others(model.count)
    alone: list[Plan] = []
    bound = 0
    try:
        for agent in range(model.count):
            plan = planner.plan(agent, NONE, others)
            if plan is None:
                return Outcome(None, 0, 0, True, 0)
            alone.append(plan)
            others = with_path(others, agent, plan.path)
        bound = sum(plan.bound for plan in alone)
        for attempt in range(orders):
            order = _order(alone, rng, attempt)
            plans = _one_order(model, planner, others, order)
            if plans is not None:
                cost = sum(plan.cost for plan in plans)
                paths = tuple(plan.path for plan in plans)
                return Outcome(paths, cost, bound, False, attempt + 1)
    except WorkOutError:
        pass
    return Outcome(None, 0, bound, False, orders)


def _order(alone: list[Plan], rng: np.random.Generator, attempt: int) -> list[int]:
    """Those that must move first; at random after the first attempt."""
    if attempt == 0:
        return sorted(range(len(alone)), key=lambda agent: -alone[agent].cost)
    return [int(agent) for agent in rng.permutation(len(alone))]


def _one_order(
    model: Model, planner: SinglePlanner, others: Others, order: list[int]
) -> list[Plan] | None:
    """Plans past the agents before (must not be hit) and those after (better not be hit)."""
    plans: dict[int, Plan] = {}
    hard = np.zeros(model.count, dtype=np.bool_)
    for agent in order:
        plan = planner.plan(agent, NONE, Others(others.paths, others.lengths, hard))
        if plan is None:
            return None
        plans[agent] = plan
        others = with_path(others, agent, plan.path)
        hard = hard.copy()
        hard[agent] = True
    # The tables know nothing of a pair that parted and meets again: look at the whole.
    together = np.zeros((model.count, model.count), dtype=np.int32)
    if len(find_conflicts(others.paths, others.lengths, model.tables, together)) > 0:
        return None
    return [plans[agent] for agent in range(model.count)]
