"""The work behind ``mamo problem generate``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from mamo_core.classify import make_classifier
from mamo_core.cli.output import progress, warn_of_broken_plugins
from mamo_core.cli.problem_files import check_output, write_problems
from mamo_core.plugins import discover
from mamo_core.problems import generate_shelf, generate_workspace
from mamo_core.problems.drawing import Classify
from mamo_core.recipes import DEFAULT_RECIPE, find_recipe, load_recipe
from mamo_core.types.problem import Problem


def run_shelf(*, level: str | None, movables: int, seed: int, count: int, output: Path) -> None:
    """Generate shelves with consecutive seeds and write them."""

    def make(seed: int, classify: Classify) -> Problem:
        return generate_shelf(movables=movables, seed=seed, level=level, classify=classify)

    words = f"{level or 'any level'}, {movables} movables"
    _run(make, words, seed, count, output)


def run_workspace(
    workspace: str,
    *,
    movables: int,
    immovables: int,
    seed: int,
    count: int,
    output: Path,
) -> None:
    """Generate reaches in a workspace of chapter 3 with consecutive seeds and write them."""

    def make(seed: int, classify: Classify) -> Problem:
        return generate_workspace(
            workspace, seed=seed, movables=movables, immovables=immovables, classify=classify
        )

    _run(make, workspace, seed, count, output)


def _run(
    make: Callable[[int, Classify], Problem], words: str, first: int, count: int, output: Path
) -> None:
    check_output(output, count)
    registry = discover()
    warn_of_broken_plugins(registry)
    classify = make_classifier(load_recipe(find_recipe(DEFAULT_RECIPE)), registry)
    problems = []
    with progress() as tell:
        for seed in range(first, first + count):
            tell(f"problem {seed - first + 1} of {count}: {words}, seed {seed}")
            problems.append(make(seed, classify))
    write_problems(problems, output)
