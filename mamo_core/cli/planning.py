"""The work behind ``mamo plan``."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mamo_core.atomic import atomic_path, check_writable
from mamo_core.choices import Choice, choose
from mamo_core.cli.output import progress, warn, warn_of_broken_plugins
from mamo_core.cli.plan_report import PlanReport, print_report
from mamo_core.compose import Planner, compose
from mamo_core.errors import InputError
from mamo_core.explain import Explanation, details_of, explain
from mamo_core.explain.words import in_words
from mamo_core.interfaces.search_strategy import ProgressCallback
from mamo_core.plan_file import PlanDocument, write_plan
from mamo_core.plugins import Registry, discover
from mamo_core.problems import load_problem
from mamo_core.recipe_sets import chosen_recipe
from mamo_core.recipes import LoadedRecipe
from mamo_core.types.problem import Problem
from mamo_core.types.search_graph import GRAPHS, KEEPS_GRAPHS
from mamo_core.types.solution import Plan, Solution
from mamo_core.warmup import load_kernels

if TYPE_CHECKING:
    from mamo_core.verify import VerifyReport

GRAPH = ".svg"


@dataclass(frozen=True)
class PlanOrder:
    """The arguments of ``mamo plan``."""

    problem: str
    planner: str
    backend: str | None = None
    settings: tuple[str, ...] = ()
    budget: float = 60.0
    seed: int = 0
    output: Path | None = None
    png: Path | None = None
    graph: Path | None = None


def run_plan(order: PlanOrder, *, as_json: bool) -> int:
    """Plan, verify, write and report; the exit code."""
    if not order.budget >= 0.0:  # also refuses NaN
        raise InputError(f"--budget {order.budget}: expected seconds, 0 or more")
    for path in (order.output, order.png, order.graph):
        if path is not None:
            check_writable(path)
    if order.graph is not None and order.graph.suffix != GRAPH:
        raise InputError(f"--graph {order.graph}: expected a name that ends in {GRAPH}")
    problem = load_problem(order.problem)
    recipe = chosen_recipe(order.planner, order.backend, order.settings)
    registry = discover()
    warn_of_broken_plugins(registry)
    with progress() as tell:
        choices = choose(recipe, problem, registry)  # complains before anything slow
        if order.graph is not None:
            _check_graph(choices, registry)
        tell("loading kernels (the first time they are compiled: about half a minute)")
        load_kernels(registry, [choice.component for choice in choices])
        tell(f"building planner {recipe.recipe.name!r} for {problem.name!r}")
        report = _solve(compose(recipe, problem, registry), order, tell)
    _write(order, problem, recipe, report)
    print_report(report, order.output, order.png, as_json=as_json)
    return report.exit_code


def _check_graph(choices: Sequence[Choice], registry: Registry) -> None:
    (search,) = (choice.component for choice in choices if choice.role == "search")
    if KEEPS_GRAPHS not in search.provides:
        able = [c.name for c in registry.components("search") if KEEPS_GRAPHS in c.provides]
        raise InputError(
            f"--graph: search {search.name!r} keeps no graph of rearrangements "
            f"(those that do: {', '.join(sorted(able))})"
        )


def _solve(planner: Planner, order: PlanOrder, tell: ProgressCallback) -> PlanReport:
    started = time.process_time()
    solution = planner.solve(order.budget, order.seed, tell)
    verification = None
    if solution.plan is not None:
        # The search has verified it too; what the command line claims it checks itself.
        tell("verifying the plan in one continuous simulation")
        verification = planner.verify(solution.plan)
    problem = planner.context.problem
    margin: dict[str, float] = {}
    if solution.plan is not None and verification is not None and verification.ok:
        margin = planner.margin(solution.plan, tell) if order.output is not None else {}
    explanation = _explained(planner, solution, tell) if solution.plan is None else None
    counted = details_of(problem.scene, solution.statistics)
    outside = verification.outside_cpu if verification is not None else 0.0
    outside += solution.statistics.outside_cpu
    return PlanReport(
        problem=problem.name,
        task=problem.task,
        recipe=planner.recipe.recipe.name,
        seed=order.seed,
        solution=solution,
        verification=verification,
        details=explanation.details if explanation is not None else counted,
        explanation=explanation,
        margin=margin,
        cpu_seconds=time.process_time() - started + outside,
    )


def _explained(planner: Planner, solution: Solution, tell: ProgressCallback) -> Explanation:
    tell("no plan: looking for what stands in the way")
    return explain(planner.context.problem, solution, planner.diagnose(solution))


def _write(order: PlanOrder, problem: Problem, recipe: LoadedRecipe, report: PlanReport) -> None:
    plan = report.verified_plan
    if plan is not None and order.output is not None:
        document = PlanDocument(
            problem=problem,
            plan=plan,
            recipe=recipe.data,
            seed=order.seed,
            margin=report.margin,
        )
        write_plan(order.output, document)
    if order.png is not None and plan is None and report.explanation is not None:
        _draw_failure(order.png, problem, report.explanation)
    elif order.png is not None:
        _draw(order.png, problem, plan, report.verification)
    if order.graph is not None:
        _draw_graph(order.graph, problem, report.solution)


def _draw_failure(path: Path, problem: Problem, why: Explanation) -> None:
    from mamo_core.view.failure import draw_failure

    with atomic_path(path) as work:
        draw_failure(
            problem,
            work,
            headline=why.headline,
            subjects=why.subjects,
            involved=why.involved,
            rows=[(d.subject, d.action, d.times, d.words) for d in why.details],
        )


def _draw(path: Path, problem: Problem, plan: Plan | None, report: VerifyReport | None) -> None:
    from mamo_core.view.topdown import draw

    rollout = report.rollout if report is not None else None
    final_state = rollout.final_state if rollout is not None else None
    with atomic_path(path) as work:
        draw(problem, plan=plan, final_state=final_state, path=work)


def _draw_graph(path: Path, problem: Problem, solution: Solution) -> None:
    from mamo_core.view.graph import draw_graph

    graphs = solution.info.get(GRAPHS)
    if not graphs:
        warn(f"--graph: there was nothing to search, {path} is not written")
        return
    with atomic_path(path) as work:
        draw_graph(problem, graphs, lambda cause: in_words(cause, (), problem.scene), work)
