"""The pathfinding contract: kept by the solvers, and sharp enough to catch cheats."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from mamo_planners.mapf.components import COMPONENTS
from mamo_planners.mapf.solvers import cbs, ecbs, portfolio, prioritized_planning

from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.testing.mapf_contract import MAPFSolverContract
from mamo_core.types.mapf import (
    MAPFAgent,
    MAPFBudget,
    MAPFProblem,
    MAPFSolution,
    MAPFStatus,
)


class TestCBS(MAPFSolverContract):
    def make_solver(self) -> MAPFSolver:
        return cbs()


class TestECBS(MAPFSolverContract):
    def make_solver(self) -> MAPFSolver:
        return ecbs(w=1.5)


class TestLooseECBS(MAPFSolverContract):
    def make_solver(self) -> MAPFSolver:
        return ecbs(w=3.0, candidates=2, flexible=False)


class TestPrioritized(MAPFSolverContract):
    complete = False

    def make_solver(self) -> MAPFSolver:
        return prioritized_planning()


class TestPortfolio(MAPFSolverContract):
    def make_solver(self) -> MAPFSolver:
        return portfolio()


class _Fake(MAPFSolver):
    """A correct solver whose problem or answer is tampered with."""

    def __init__(
        self,
        before: Callable[[MAPFProblem], MAPFProblem] = lambda problem: problem,
        after: Callable[[MAPFSolution], MAPFSolution] = lambda solution: solution,
    ) -> None:
        self._before = before
        self._after = after

    def solve(
        self, problem: MAPFProblem, budget: MAPFBudget, rng: np.random.Generator
    ) -> MAPFSolution:
        return self._after(cbs().solve(self._before(problem), budget, rng))


class _EachAlone(MAPFSolver):
    """Ignores conflicts: every agent for itself."""

    def solve(
        self, problem: MAPFProblem, budget: MAPFBudget, rng: np.random.Generator
    ) -> MAPFSolution:
        parts = [
            cbs().solve(replace(problem, agents=(agent,)), budget, rng) for agent in problem.agents
        ]
        failed = [part for part in parts if not part.solved]
        if failed:
            return failed[0]
        cost = sum(part.cost for part in parts)
        paths = {name: path for part in parts for name, path in part.paths.items()}
        return MAPFSolution(MAPFStatus.OPTIMAL, paths, cost, cost, 1.0)


def _without_penalties(problem: MAPFProblem) -> MAPFProblem:
    agents = tuple(replace(agent, penalties=()) for agent in problem.agents)
    return replace(problem, agents=agents)


def _each_once(agent: MAPFAgent) -> MAPFAgent:
    return replace(agent, penalties=agent.penalties[:1])


def _detour(solution: MAPFSolution) -> MAPFSolution:
    """A step back and forth at the start of every path of more than one row, unpaid for."""
    if not solution.solved:
        return solution
    paths = {
        name: path if len(path) == 1 else np.concatenate([path[:2], path[:1], path[1:]])
        for name, path in solution.paths.items()
    }
    return replace(solution, paths=paths)


def _detour_paid(solution: MAPFSolution) -> MAPFSolution:
    """The same with its cost, still called optimal."""
    cost = solution.cost + 2.0 * sum(len(path) > 1 for path in solution.paths.values())
    return replace(_detour(solution), cost=cost, lower_bound=cost)


def _wandering() -> Callable[[MAPFSolution], MAPFSolution]:
    """Another cost each time."""
    calls = itertools.count()
    return lambda solution: replace(solution, cost=solution.cost + 1e-9 * next(calls))


def _give_up_as_infeasible(solution: MAPFSolution) -> MAPFSolution:
    if solution.status is MAPFStatus.TIMEOUT:
        return replace(solution, status=MAPFStatus.INFEASIBLE)
    return solution


def _always_solved(solution: MAPFSolution) -> MAPFSolution:
    if solution.solved:
        return solution
    return MAPFSolution(MAPFStatus.OPTIMAL, {}, 0.0, 0.0, 1.0)


def _no_blame(solution: MAPFSolution) -> MAPFSolution:
    return replace(solution, blame={})


def _contract(fake: MAPFSolver) -> MAPFSolverContract:
    contract = MAPFSolverContract()
    contract.make_solver = lambda: fake  # type: ignore[method-assign]
    return contract


CHEATS: dict[str, tuple[MAPFSolver, str]] = {
    "ignores conflicts": (_EachAlone(), "test_agents_do_not_run_into_each_other"),
    "never steps aside": (_EachAlone(), "test_one_steps_aside_for_the_other"),
    "ignores obstacles": (
        _Fake(before=lambda problem: replace(problem, obstacles=())),
        "test_agents_do_not_run_into_obstacles",
    ),
    "ignores forbidden goals": (
        _Fake(before=_without_penalties),
        "test_forbidden_goals_are_not_used",
    ),
    "stays where it may not": (
        _Fake(before=_without_penalties),
        "test_a_start_may_be_forbidden_too",
    ),
    "ignores penalties": (
        _Fake(before=_without_penalties),
        "test_penalties_are_weighed_against_steps",
    ),
    "counts a place once": (
        _Fake(before=lambda p: replace(p, agents=tuple(_each_once(a) for a in p.agents))),
        "test_penalties_of_one_place_add_up",
    ),
    "hides a detour": (_Fake(after=_detour), "test_one_agent_walks_out_by_the_shortest_way"),
    "calls a detour optimal": (
        _Fake(after=_detour_paid),
        "test_one_agent_walks_out_by_the_shortest_way",
    ),
    "moves what may stay": (
        _Fake(
            after=lambda s: replace(s, paths={n: np.repeat(p, 2, 0) for n, p in s.paths.items()})
        ),
        "test_an_agent_outside_stays_at_no_cost",
    ),
    "is not deterministic": (_Fake(after=_wandering()), "test_equal_inputs_give_equal_paths"),
    "calls a timeout infeasible": (
        _Fake(after=_give_up_as_infeasible),
        "test_little_work_gives_an_honest_answer",
    ),
    "always has a solution": (_Fake(after=_always_solved), "test_nobody_claims_a_solution"),
    "blames nobody": (_Fake(after=_no_blame), "test_nobody_claims_a_solution"),
    "fails without agents": (
        _Fake(after=lambda s: s if s.paths else replace(s, status=MAPFStatus.TIMEOUT)),
        "test_no_agents_is_solved",
    ),
}


@pytest.mark.parametrize("name", CHEATS)
def test_the_contract_catches_a_solver_that(name: str) -> None:
    fake, check = CHEATS[name]
    tests = [test for test in dir(MAPFSolverContract) if test.startswith(check)]
    assert len(tests) == 1, check
    with pytest.raises(AssertionError):
        getattr(_contract(fake), tests[0])()


def test_the_contract_itself_passes_a_good_solver() -> None:
    contract = _contract(_Fake())
    for test in dir(MAPFSolverContract):
        if test.startswith("test_"):
            getattr(contract, test)()


def test_a_contract_without_a_solver_says_what_to_do() -> None:
    with pytest.raises(NotImplementedError, match="make_solver"):
        MAPFSolverContract().make_solver()


@pytest.mark.parametrize("component", COMPONENTS, ids=lambda component: component.name)
def test_components_build_solvers(component: object) -> None:
    part = next(c for c in COMPONENTS if c is component)
    assert isinstance(part.build(None, part.options()), MAPFSolver)
    for name, field in part.options.model_fields.items():
        assert field.description, name
