"""Solves problems one after another and makes a row of each."""

from __future__ import annotations

import gc
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from success_rows import Row, RowFile

from mamo_core.cli.generating import make_classifier
from mamo_core.cli.planning import chosen_recipe
from mamo_core.compose import build_parts, choose, compose, make_verifier
from mamo_core.config import Located
from mamo_core.plan_file import PlanDocument, read_plan, write_plan
from mamo_core.plugins import Registry, discover
from mamo_core.problems import generate_shelf
from mamo_core.problems.files import read_entries
from mamo_core.problems.generator import level_of
from mamo_core.recipes import DEFAULT_RECIPE, LoadedRecipe, load_recipe
from mamo_core.types.problem import Problem
from mamo_core.types.solution import Plan, Solution, Statistics
from mamo_core.warmup import load_kernels
from mamo_core.warmup import warm_up as warm_up_plugins

_WARM_UP_BUDGET = 5.0
_EMPTY: Row = {
    "movables": 0,
    "difficulty": "unknown",
    "status": "error",
    "verified": False,
    "cpu_s": 0.0,
    "parts": {},
    "actions": 0,
    "rollouts": 0,
    "valid_rollouts": 0,
    "causes": {},
    "reason": "",
}


@dataclass(frozen=True)
class Picked:
    """A problem of a set, not yet loaded."""

    set_name: str
    id: str
    load: Callable[[], tuple[Problem, list[str]]]

    @property
    def key(self) -> tuple[str, str]:
        """Set and id."""
        return self.set_name, self.id


def pick(sets: Sequence[Path], every: int = 1, limit: int | None = None) -> list[Picked]:
    """The problems to solve: of each set every k-th, and of those so many."""
    return [
        Picked(path.name.split(".")[0], entry.id, entry.load)
        for path in sets
        for entry in read_entries(path)[::every][:limit]
    ]


class Runner:
    """A recipe with budget (CPU s) and seed, ready for problems."""

    def __init__(self, planner: str, settings: tuple[str, ...], budget: float, seed: int) -> None:
        self.recipe = chosen_recipe(planner, None, settings)
        self._budget, self._seed = budget, seed
        self._registry = discover()
        default = chosen_recipe(DEFAULT_RECIPE)
        self._classify = make_classifier(default, self._registry)

    def run(self, picked: Sequence[Picked], rows: RowFile) -> bool:
        """Solve what has no row yet; False if interrupted."""
        missing = [entry for entry in picked if rows.find(entry.key) is None]
        try:
            if missing:
                warm_up(self.recipe, self._registry)
            for number, entry in enumerate(missing, len(picked) - len(missing) + 1):
                row = self.row(entry)
                rows.add(row)
                _tell(f"[{number}/{len(picked)}] {line_of(row)}")
        except KeyboardInterrupt:
            _tell("interrupted")
            return False
        return True

    def row(self, entry: Picked) -> Row:
        """Solve a problem; whatever goes wrong is part of the result."""
        start: Row = {"set": entry.set_name, "id": entry.id, **_EMPTY}
        gc.collect()
        try:
            return {**start, **self._solved(entry)}
        except Exception as error:
            return {**start, "reason": f"{type(error).__name__}: {error}"}

    def _solved(self, entry: Picked) -> Row:
        started = time.process_time()
        problem, _ = entry.load()
        loaded = time.process_time()
        planner = compose(self.recipe, problem, self._registry)
        composed = time.process_time()
        solution = planner.solve(max(0.0, self._budget - (composed - started)), self._seed)
        cpu = time.process_time() - started
        statistics = solution.statistics
        parts = {"loading": loaded - started, "composing": composed - loaded}
        parts |= {part: float(seconds) for part, seconds in statistics.seconds.items()}
        parts["other"] = max(0.0, cpu - sum(parts.values()))
        return {
            "movables": len(problem.scene.movable_indices),
            "difficulty": difficulty(self._classify(problem)),
            "cpu_s": cpu,
            "parts": parts,
            **_counted(statistics),
            **self._outcome(problem, solution),
        }

    def _outcome(self, problem: Problem, solution: Solution) -> Row:
        plan = solution.plan
        failures: tuple[str, ...] = ()
        if plan is not None:
            failures = replayed(problem, plan, self.recipe, self._seed, self._registry)
        return {
            "status": str(solution.status),
            "verified": plan is not None and not failures,
            "actions": len(plan.actions) if plan is not None else 0,
            "reason": "; ".join(failures) or solution.reason,
        }


def _counted(statistics: Statistics) -> Row:
    return {
        "rollouts": int(statistics.counts["rollouts"]),
        "valid_rollouts": int(statistics.counts["valid_rollouts"]),
        "causes": {key: int(times) for key, times in statistics.causes.most_common() if times},
    }


def difficulty(in_the_way: int | None) -> str:
    """Class by the number of movables in the initial NGR of one canonical, seeded retrieval."""
    if in_the_way is None:
        return "unreachable"
    return level_of(in_the_way) or "none"


def replayed(
    problem: Problem, plan: Plan, recipe: LoadedRecipe, seed: int, registry: Registry
) -> tuple[str, ...]:
    """What fails when the plan is written, read back and replayed in a freshly built model."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plan.json"
        write_plan(path, PlanDocument(problem, plan, recipe.data, seed))
        document = read_plan(path)
    again = load_recipe(Located(dict(document.recipe), "plan.json: recipe"))
    choices = choose(again, document.problem, registry, ("constraint", "backend"))
    return make_verifier(build_parts(choices, document.problem))(document.plan).failures


def warm_up(recipe: LoadedRecipe, registry: Registry) -> None:
    """Compile, import and cache what the first problem would otherwise pay for."""
    for piece in warm_up_plugins(registry):
        _tell(f"warm-up: {piece}")
    load_kernels(registry)
    _tell("warm-up: a first problem")
    problem = generate_shelf(movables=3, seed=1)
    planner = compose(recipe, problem, registry)
    plan = planner.solve(_WARM_UP_BUDGET).plan
    if plan is not None:
        replayed(problem, plan, recipe, 0, registry)


def line_of(row: dict[str, Any]) -> str:
    """A row in a line."""
    words = [
        f"{row['set']}#{row['id']}",
        row["difficulty"],
        row["status"] + (", verified" if row["verified"] else ""),
        f"{row['cpu_s']:.2f} s, {row['actions']} actions, {row['rollouts']} rollouts",
    ]
    return "  ".join(words) + (f"  ({row['reason']})" if row["reason"] else "")


def _tell(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
