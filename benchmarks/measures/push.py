"""One simulated push: sweep, settling and retract, with 15 objects on the shelf."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np
from mamo_planners.search.abstraction import mapf_problem
from mamo_planners.search.options import GreedyOptions

from mamo_core.build_context import BuildContext
from mamo_core.choices import BUILD_ORDER
from mamo_core.interfaces.action_generator import ActionRequest
from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.plugins import Registry
from mamo_core.types.action import RearrangementAction
from mamo_core.types.mapf import MAPFBudget
from mamo_core.types.solution import Statistics
from measures.common import Measured, cpu_seconds, initial_region, shelves

MOVABLES = 10
"""With 4 immovables and the target: 15 objects."""
PUSHES = 30
PER_OBJECT = 2
ROLES = tuple(role for role in BUILD_ORDER if role not in ("accept_in", "search"))


def measure(registry: Registry) -> Measured:
    """CPU time to the end of the push, whatever it breaks, and with an early stop."""
    whole, stopped, valid, simulated = [], [], 0, []
    for context, action in islice(pushes(registry), PUSHES):
        model, sweep = context.part("backend"), action.motion.after_transit()
        state = context.problem.initial.with_joints(sweep.start)
        result = model.rollout(state, sweep, options=RolloutOptions(stop_early=False))
        valid += result.valid
        simulated.append(result.duration)
        for seconds, early in ((whole, False), (stopped, True)):
            options = RolloutOptions(stop_early=early)
            seconds.append(
                cpu_seconds(
                    lambda m=model, s=state, motion=sweep, o=options: m.rollout(
                        s, motion, options=o
                    )
                )
            )
    how = (
        f"{PUSHES} pushes proposed for MAPF paths, {valid} of them valid, simulated to the end "
        f"({np.median(simulated):.1f} s of time); stopped at the first violation: "
        f"{np.median(stopped):.3f} s"
    )
    return Measured({"push_cpu_s": float(np.median(whole))}, {"push_cpu_s": how})


def pushes(registry: Registry) -> Iterator[tuple[BuildContext, RearrangementAction]]:
    """Pushes proposed for MAPF paths, and the parts they were made with."""
    for context in shelves(registry, MOVABLES, ROLES):
        rng = np.random.default_rng(0)
        for request in requests(context, rng):
            for _, generator in context.actions:
                proposals = generator.propose(context.problem.initial, request, rng, Statistics())
                for action in islice(proposals, PER_OBJECT):
                    yield context, action


def requests(context: BuildContext, rng: np.random.Generator) -> list[ActionRequest]:
    """Objects to push out of the initial NGR, and along which paths."""
    problem, region, options = context.problem, initial_region(context), GreedyOptions()
    if region is None:
        return []
    abstract = mapf_problem(problem, problem.initial, region, {}, options.goal_margin)
    budget = MAPFBudget(options.mapf_nodes, options.mapf_expansions)
    paths = context.part("mapf").solve(abstract, budget, rng).paths
    return [ActionRequest(name, path, region) for name, path in paths.items() if len(path) > 1]
