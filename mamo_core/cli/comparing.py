"""The work behind ``mamo compare``."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mamo_core.atomic import atomic_path, check_writable
from mamo_core.choices import choose
from mamo_core.cli.output import print_json, print_table, progress, warn_of_broken_plugins
from mamo_core.compose import build_parts, compose
from mamo_core.errors import InputError
from mamo_core.interfaces.search_strategy import ProgressCallback
from mamo_core.plan_file import is_plan_file, read_plan
from mamo_core.plugins import Registry, discover
from mamo_core.problems import load_problem
from mamo_core.recipe_sets import chosen_recipe
from mamo_core.recipes import DEFAULT_RECIPE
from mamo_core.types.problem import Problem
from mamo_core.types.solution import Plan
from mamo_core.warmup import load_kernels

if TYPE_CHECKING:
    from mamo_core.compare.plans import PlanComparison
    from mamo_core.interfaces.transition_model import TransitionModel
    from mamo_core.robots.model import ArmModel

NO_PLAN = 3


@dataclass(frozen=True)
class CompareOrder:
    """The arguments of ``mamo compare``."""

    subjects: tuple[str, ...]
    backends: tuple[str, ...]
    planner: str = DEFAULT_RECIPE
    settings: tuple[str, ...] = ()
    budget: float = 60.0
    seed: int = 0
    samples: int = 3
    output: Path | None = None
    png: Path | None = None
    trace: Path | None = None


@dataclass(frozen=True, eq=False)
class Made:
    """A plan and the engine it was made with."""

    problem: Problem
    planned_with: str
    plan: Plan


def run_compare(order: CompareOrder, *, as_json: bool) -> int:
    """Plan where needed, execute everywhere, write and report; the exit code."""
    _check(order)
    registry = discover()
    warn_of_broken_plugins(registry)
    comparisons: list[PlanComparison] = []
    unsolved: list[dict[str, str]] = []
    with progress() as tell:
        for subject in order.subjects:
            for made in _plans(subject, order, registry, tell, unsolved):
                tell(f"executing the plan of {made.planned_with} for {made.problem.name!r}")
                comparisons.append(_compared(made, order, registry))
    _write(order, comparisons, unsolved)
    _print(comparisons, unsolved, as_json=as_json)
    return 0 if comparisons else NO_PLAN


def _check(order: CompareOrder) -> None:
    if len(order.backends) < 2 or len(set(order.backends)) < len(order.backends):
        raise InputError(f"--backends {','.join(order.backends)}: expected two or more different")
    for path in (order.output, order.png, order.trace):
        if path is not None:
            check_writable(path)


def _plans(
    subject: str,
    order: CompareOrder,
    registry: Registry,
    tell: ProgressCallback,
    unsolved: list[dict[str, str]],
) -> Iterator[Made]:
    """The plan in a file, or a plan of each engine for a problem."""
    if is_plan_file(subject):
        document = read_plan(subject)
        backend = document.recipe.get("backend", "unknown")
        name = backend if isinstance(backend, str) else str(backend.get("name"))
        yield Made(document.problem, name, document.plan)
        return
    problem = load_problem(subject)
    for backend in order.backends:
        tell(f"planning {problem.name!r} with {backend}")
        recipe = chosen_recipe(order.planner, backend, order.settings)
        choices = choose(recipe, problem, registry)
        load_kernels(registry, [choice.component for choice in choices])
        solution = compose(recipe, problem, registry).solve(order.budget, order.seed, tell)
        if solution.plan is not None:
            yield Made(problem, backend, solution.plan)
        else:
            row = {"problem": problem.name, "planned_with": backend, "reason": solution.reason}
            unsolved.append(row)


def _compared(made: Made, order: CompareOrder, registry: Registry) -> PlanComparison:
    from mamo_core.compare.plans import compare_plan

    models, robot = engines_for(made.problem, order.backends, order.planner, registry)
    return compare_plan(
        made.problem, made.plan, made.planned_with, models, robot, samples=order.samples
    )


def engines_for(
    problem: Problem, backends: Sequence[str], planner: str, registry: Registry
) -> tuple[dict[str, TransitionModel], ArmModel]:
    """A model of each engine with its default options, and the robot."""
    models: dict[str, TransitionModel] = {}
    for backend in backends:
        recipe = chosen_recipe(planner, backend)
        context = build_parts(choose(recipe, problem, registry, ("constraint", "backend")), problem)
        models[backend] = context.part("backend")
    return models, context.robot


def _write(
    order: CompareOrder, comparisons: list[PlanComparison], unsolved: list[dict[str, str]]
) -> None:
    from mamo_core.compare.report import report_data

    if order.output is not None:
        data = {"schema_version": 1, **report_data(comparisons), "unsolved": unsolved}
        with atomic_path(order.output) as work:
            work.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    first = next((c for c in comparisons if c.tracks is not None), None)
    if first is None or first.tracks is None:
        return
    if order.trace is None and order.png is None:
        return
    from mamo_core.recording import recording_of, write_recording

    reports = {execution.engine: execution.report for execution in first.executions}
    recording = recording_of(first.problem, first.plan, reports)
    if order.trace is not None:
        write_recording(order.trace, recording)
    if order.png is not None:
        from mamo_core.view.engines import draw_engines

        with atomic_path(order.png) as work:
            title = f"{first.problem.name}, planned with {first.planned_with}"
            draw_engines(recording, work, title)


def _print(
    comparisons: list[PlanComparison], unsolved: list[dict[str, str]], *, as_json: bool
) -> None:
    from mamo_core.compare.report import report_data

    data = report_data(comparisons)
    if as_json:
        print_json("compare", {**data, "unsolved": unsolved})
        return
    print_table(
        "transfer",
        ("planned with", "executed in", "plans", "valid", "failures"),
        (_transfer_row(row) for row in data["transfer"]),
    )
    print_table(
        "where engines part",
        ("problem", "planned with", "action", "engines", "first", "apart mm", "chaos mm"),
        (row for plan in data["plans"] for row in _divergence_rows(plan)),
    )
    for row in unsolved:
        print(f"{row['problem']}: no plan with {row['planned_with']}: {row['reason']}")


def _transfer_row(row: dict[str, Any]) -> list[str]:
    failures = ", ".join(f"{kind} {count}" for kind, count in row["failures"].items())
    counts = [str(row["plans"]), str(row["valid"])]
    return [row["planned_with"], row["executed_in"], *counts, failures]


def _divergence_rows(plan: dict[str, Any]) -> Iterator[list[str]]:
    for item in plan["divergences"]:
        floors = "/".join("-" if f is None else f"{f:.1f}" for f in item["chaos_floor_mm"])
        yield [
            plan["problem"],
            plan["planned_with"],
            f"{item['action'] + 1} {plan['actions'][item['action']]}",
            " - ".join(item["engines"]),
            _first(item["first"]),
            f"{item['apart_mm']:.1f}",
            floors,
        ]


def _first(first: dict[str, Any] | None) -> str:
    if first is None:
        return "agree"
    alone = f" in {first['alone']} alone" if first["alone"] else ""
    return f"{first['kind']} of {first['subject']}{alone} at {first['time_s']:.2f} s"
