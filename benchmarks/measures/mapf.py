"""MAPF on the real negative goal regions of shelves."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np
from mamo_planners.search.abstraction import mapf_problem, occupied
from mamo_planners.search.options import GreedyOptions

from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.plugins import Registry
from mamo_core.types.mapf import MAPFBudget, MAPFProblem, MAPFSolution
from measures.common import Measured, cpu_seconds, initial_region, shelves

INSTANCES = {10: 60, 15: 100}
ROLES = ("kinematics", "collision", "arm_planner", "retrieval", "mapf")


def measure(registry: Registry) -> Measured:
    """CPU time from the abstract problem to paths, tables included."""
    times = {movables: _milliseconds(registry, movables) for movables in INSTANCES}
    values = {
        "mapf10_ms_median": float(np.median(times[10][0])),
        "mapf15_ms_p95": float(np.quantile(times[15][0], 0.95)),
    }
    how = {
        key: f"{INSTANCES[movables]} shelves with {movables} movables, at least one in the NGR; "
        f"{times[movables][1]} solved; {_spread(times[movables][0])}; CPU"
        for key, movables in (("mapf10_ms_median", 10), ("mapf15_ms_p95", 15))
    }
    return Measured(values, how)


def _milliseconds(registry: Registry, movables: int) -> tuple[list[float], int]:
    options = GreedyOptions()
    budget = MAPFBudget(options.mapf_nodes, options.mapf_expansions)
    milliseconds: list[float] = []
    solved = 0
    for solver, problem in islice(_instances(registry, movables), INSTANCES[movables]):
        solutions: list[MAPFSolution] = []
        rng = np.random.default_rng(0)
        seconds = cpu_seconds(
            lambda s=solver, p=problem, r=rng, out=solutions: out.append(s.solve(p, budget, r))
        )
        milliseconds.append(1e3 * seconds)
        solved += solutions[0].solved
    return milliseconds, solved


def _instances(registry: Registry, movables: int) -> Iterator[tuple[MAPFSolver, MAPFProblem]]:
    margin = GreedyOptions().goal_margin
    for context in shelves(registry, movables, ROLES):
        problem, region = context.problem, initial_region(context)
        if region is not None and occupied(problem, problem.initial, region):
            yield (
                context.part("mapf"),
                mapf_problem(problem, problem.initial, region, {}, margin),
            )


def _spread(milliseconds: list[float]) -> str:
    median, p95 = np.quantile(milliseconds, [0.5, 0.95])
    return f"median {median:.1f}, p95 {p95:.1f}, max {max(milliseconds):.1f} ms"
