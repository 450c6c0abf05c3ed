"""The solvers: optimal, bounded, prioritised, and one after the other until one succeeds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mamo_core.errors import InputError
from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.types.geometry import Array
from mamo_core.types.mapf import MAPFAgent, MAPFBudget, MAPFProblem, MAPFSolution, MAPFStatus
from mamo_planners.mapf.conflict_search import ConflictSearch, Outcome
from mamo_planners.mapf.low_level import Workspace
from mamo_planners.mapf.model import UNIT, Model
from mamo_planners.mapf.prioritized import prioritized
from mamo_planners.mapf.single import SinglePlanner, nowhere
from mamo_planners.mapf.tables import Int32Array

Stage = Callable[[Model, SinglePlanner, int, np.random.Generator], Outcome]
"""A search: model, planner with its work limit, node limit, generator."""


class StagedSolver(MAPFSolver):
    """Stages in turn, each with a share of the budget, until one has a solution.

    ``stages``: (share of the budget, factor it guarantees or inf, search). What a stage leaves
    goes to the next ones. The lower bound is the best of all stages.
    """

    def __init__(self, stages: tuple[tuple[float, float, Stage], ...]) -> None:
        self._stages = stages
        # Stamped entries of one search mean nothing to the next: only the memory is shared.
        self._workspace: Workspace | None = None

    def solve(
        self, problem: MAPFProblem, budget: MAPFBudget, rng: np.random.Generator
    ) -> MAPFSolution:
        """Conflict-free paths out of the region; status and bounds as ``MAPFSolution`` says."""
        if not problem.agents:
            return MAPFSolution(MAPFStatus.OPTIMAL, cost=0.0, bound=1.0)
        model = Model(problem)
        reasons = {a.name: nowhere(model, i) for i, a in enumerate(problem.agents)}
        blame = {name: reason for name, reason in reasons.items() if reason}
        if blame:
            return MAPFSolution(MAPFStatus.INFEASIBLE, lower_bound=float("inf"), blame=blame)
        planner = SinglePlanner(model, 0, self._workspace)
        try:
            return self._staged(problem, budget, rng, model, planner)
        finally:
            self._workspace = planner.workspace

    def _staged(
        self,
        problem: MAPFProblem,
        budget: MAPFBudget,
        rng: np.random.Generator,
        model: Model,
        planner: SinglePlanner,
    ) -> MAPFSolution:
        bound, nodes = 0, 0
        shares = sum(stage[0] for stage in self._stages)
        for share, factor, search in self._stages:
            part = share / shares if shares > 0.0 else 0.0
            shares -= share
            planner.limit = planner.expansions + int(
                part * (budget.expansions - planner.expansions)
            )
            outcome = search(model, planner, int(part * (budget.nodes - nodes)), rng)
            nodes += outcome.nodes
            bound = max(bound, outcome.bound)
            if outcome.exhausted:
                return MAPFSolution(
                    MAPFStatus.INFEASIBLE,
                    lower_bound=float("inf"),
                    nodes=nodes,
                    expansions=planner.expansions,
                )
            if outcome.paths is not None:
                solution = _solution(problem, outcome, bound, factor)
                return replace(solution, nodes=nodes, expansions=planner.expansions)
        return MAPFSolution(
            MAPFStatus.TIMEOUT,
            lower_bound=bound / UNIT,
            nodes=nodes,
            expansions=planner.expansions,
        )


def conflict_stage(weight: float, candidates: int, flexible: bool = False) -> Stage:
    """CBS (``weight`` 1) or ECBS as a stage."""

    def run(model: Model, planner: SinglePlanner, nodes: int, rng: np.random.Generator) -> Outcome:
        return ConflictSearch(model, planner, weight, nodes, candidates, flexible).run()

    return run


def prioritized_stage(orders: int) -> Stage:
    """Prioritised planning as a stage; an order counts as a node."""

    def run(model: Model, planner: SinglePlanner, nodes: int, rng: np.random.Generator) -> Outcome:
        return prioritized(model, planner, rng, min(orders, nodes))

    return run


def cbs(candidates: int = 4) -> MAPFSolver:
    """Optimal conflict-based search."""
    return StagedSolver(((1.0, 1.0, conflict_stage(1.0, candidates)),))


def ecbs(w: float = 1.5, candidates: int = 1, flexible: bool = True) -> MAPFSolver:
    """Conflict-based search within ``w`` times the optimum."""
    return StagedSolver(((1.0, w, conflict_stage(w, candidates, flexible)),))


def prioritized_planning(orders: int = 100) -> MAPFSolver:
    """Prioritised planning over up to ``orders`` priority orders."""
    return StagedSolver(((1.0, float("inf"), prioritized_stage(orders)),))


def portfolio(
    cbs_share: float = 0.006,
    candidates: int = 2,
    tight: tuple[float, float] = (0.015, 1.5),
    loose: tuple[float, float] = (0.10, 3.0),
    orders: int = 1000,
) -> MAPFSolver:
    """CBS, ECBS ``tight`` and ``loose`` (share of the budget, factor), then prioritised planning.

    Raises:
        InputError: the shares add up to more than 1.
    """
    rest = 1.0 - cbs_share - tight[0] - loose[0]
    if rest < -1e-9:
        raise InputError(f"portfolio: shares add up to {1.0 - rest:g} (valid: at most 1)")
    return StagedSolver(
        (
            (cbs_share, 1.0, conflict_stage(1.0, candidates)),
            (tight[0], tight[1], conflict_stage(tight[1], 1, flexible=True)),
            (loose[0], loose[1], conflict_stage(loose[1], 1)),
            (max(rest, 0.0), float("inf"), prioritized_stage(orders)),
        )
    )


def _solution(problem: MAPFProblem, outcome: Outcome, bound: int, factor: float) -> MAPFSolution:
    assert outcome.paths is not None
    paths = {
        agent.name: _world_path(agent, steps, problem.resolution)
        for agent, steps in zip(problem.agents, outcome.paths, strict=True)
    }
    cost = sum(path_cost(a, paths[a.name], problem.wait_cost) for a in problem.agents)
    lower = min(bound / UNIT, cost)
    if outcome.cost <= bound:
        return MAPFSolution(MAPFStatus.OPTIMAL, paths, cost, lower, 1.0)
    ratio = cost / lower if lower > 0.0 else float("inf")
    status = MAPFStatus.BOUNDED if np.isfinite(factor) else MAPFStatus.FEASIBLE
    return MAPFSolution(status, paths, cost, lower, ratio)


def _world_path(agent: MAPFAgent, steps: Int32Array, resolution: float) -> Array:
    path: Array = agent.pose[:2] + steps * resolution
    path.flags.writeable = False
    return path


def path_cost(agent: MAPFAgent, path: Array, wait_cost: float) -> float:
    """What ``path`` (T + 1, 2) m costs the agent, in lattice steps, its goal penalties included."""
    if len(path) == 1 and not agent.penalties:
        return 0.0
    moved = np.any(np.abs(np.diff(path, axis=0)) > 1e-9, axis=1)
    moved = np.atleast_1d(moved)
    last = int(np.flatnonzero(moved)[-1]) + 1 if moved.any() else 0
    total = float(moved.sum()) + wait_cost * float(last - moved[:last].sum())
    field = agent.cost_field
    if field is not None:
        cells = np.floor((path[1:][moved] - field.origin) / field.resolution + 1e-9).astype(int)
        inside = ((cells >= 0) & (cells < field.values.shape)).all(axis=1)
        total += float(field.values[tuple(cells[inside].T)].sum())
    for penalty in agent.penalties:
        if np.hypot(*(path[-1] - penalty.position)) <= penalty.radius + 1e-9:
            total += penalty.cost
    return total
