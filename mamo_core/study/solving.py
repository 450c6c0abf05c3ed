"""What worker processes do: get ready, solve, classify, generate. All of it from plain data."""

from __future__ import annotations

import gc
import time
import zlib
from functools import cache
from typing import Any

from mamo_core import problems
from mamo_core.classify import class_of, make_classifier
from mamo_core.compose import compose
from mamo_core.config import Located
from mamo_core.errors import WorkerCrashedError
from mamo_core.plan_file import PlanDocument, plan_text
from mamo_core.plugins import Registry, discover
from mamo_core.problems import generate_shelf, problem_document, problem_from_document
from mamo_core.recipe_sets import chosen_recipe
from mamo_core.recipes import DEFAULT_RECIPE, LoadedRecipe, load_recipe
from mamo_core.study.code import code_version
from mamo_core.study.replay import replay_failures
from mamo_core.types.problem import Problem, Task
from mamo_core.types.solution import Solution
from mamo_core.warmup import load_kernels

Row = dict[str, Any]
_FIRST_BUDGET = 5.0


def get_ready(recipe: dict[str, Any], robots: list[str], code: str) -> None:
    """Import, load and cache what the first problem would otherwise pay for.

    Raises:
        WorkerCrashedError: this is not the code that rows would be said to be of.
    """
    from mamo_core.robots import load_arm

    get_ready_to_classify(code)
    for robot in robots:
        load_arm(robot)
    loaded = _recipe(recipe)
    problem = _first_problem(loaded)
    solution = compose(loaded, problem, _registry()).solve(_FIRST_BUDGET)
    if solution.plan is not None:
        replay_failures(_text(problem, solution, loaded, 0), _registry())


def _first_problem(recipe: LoadedRecipe) -> Problem:
    """A small one of a task that the recipe's search plans for."""
    (part,) = recipe.parts("search")
    tasks = _registry().component("search", part.name, part.place).tasks
    if Task.RETRIEVE in tasks:
        return generate_shelf(movables=3, seed=1)
    return problems.generate_workspace("tabletop", movables=3, immovables=1, seed=1)


def get_ready_to_classify(code: str) -> None:
    """As ``get_ready``, but for what is the same for all recipes: classes are not timed."""
    if code_version() != code:
        raise WorkerCrashedError(f"a worker has other code ({code_version()}) than the study")
    load_kernels(_registry())


def solve(problem: dict[str, Any], recipe: dict[str, Any], seed: int, budget: float) -> Row:
    """Solve a problem and have the plan checked; ``budget`` and ``cpu_s`` begin with its data."""
    gc.collect()
    started = time.process_time()
    loaded = _recipe(recipe)
    scene = problem_from_document(problem, "problem")
    read = time.process_time()
    planner = compose(loaded, scene, _registry())
    composed = time.process_time()
    solution = planner.solve(max(0.0, budget - (composed - started)), seed)
    cpu = time.process_time() - started + solution.statistics.outside_cpu
    parts = {"loading": read - started, "composing": composed - read}
    parts |= {part: float(s) for part, s in solution.statistics.seconds.items()}
    parts["other"] = max(0.0, cpu - sum(parts.values()))
    return {"cpu_s": cpu, "parts": parts, **_outcome(scene, solution, loaded, seed)}


def classify(problem: dict[str, Any]) -> str:
    """The class of a problem."""
    recipe = chosen_recipe(DEFAULT_RECIPE)
    scene = problem_from_document(problem, "problem")
    return class_of(make_classifier(recipe, _registry())(scene))


def generate(level: str, movables: int, seed: int) -> dict[str, Any]:
    """A shelf as plain data."""
    classifier = make_classifier(chosen_recipe(DEFAULT_RECIPE), _registry())
    problem = generate_shelf(movables=movables, seed=seed, level=level, classify=classifier)
    return problem_document(problem)


def generate_workspace(workspace: str, movables: int, immovables: int, seed: int) -> dict[str, Any]:
    """A reach in a workspace of chapter 3 as plain data."""
    problem = problems.generate_workspace(
        workspace,
        movables=movables,
        immovables=immovables,
        seed=seed,
        classify=make_classifier(chosen_recipe(DEFAULT_RECIPE), _registry()),
    )
    return problem_document(problem)


def _outcome(problem: Problem, solution: Solution, recipe: LoadedRecipe, seed: int) -> Row:
    statistics, plan = solution.statistics, solution.plan
    text = _text(problem, solution, recipe, seed) if plan is not None else None
    failures = replay_failures(text, _registry()) if text is not None else ()
    return {
        "status": str(solution.status),
        "verified": text is not None and not failures,
        "actions": len(plan.actions) if plan is not None else 0,
        "counts": {key: int(n) for key, n in statistics.counts.items() if n},
        "causes": {key: int(n) for key, n in statistics.causes.most_common() if n},
        "reason": "; ".join(failures) or solution.reason,
        "plan": zlib.compress(text.encode("utf-8")) if text is not None else None,
    }


def _text(problem: Problem, solution: Solution, recipe: LoadedRecipe, seed: int) -> str:
    assert solution.plan is not None, "there is nothing to write"
    document = PlanDocument(
        problem=problem,
        plan=solution.plan,
        recipe=recipe.data,
        seed=seed,
    )
    return plan_text(document)


def _recipe(data: dict[str, Any]) -> LoadedRecipe:
    return load_recipe(Located(data, f"recipe {data.get('name')!r}"))


@cache
def _registry() -> Registry:
    return discover()
