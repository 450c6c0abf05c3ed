"""The work behind ``mamo problem generate``."""

from __future__ import annotations

from pathlib import Path

from mamo_core.classify import make_classifier
from mamo_core.cli.output import progress, warn_of_broken_plugins
from mamo_core.cli.problem_files import check_output, write_problems
from mamo_core.plugins import discover
from mamo_core.problems import generate_shelf
from mamo_core.recipes import DEFAULT_RECIPE, find_recipe, load_recipe


def run_generate(*, level: str, movables: int, seed: int, count: int, output: Path) -> None:
    """Generate problems with consecutive seeds and write them."""
    check_output(output, count)
    registry = discover()
    warn_of_broken_plugins(registry)
    classify = make_classifier(load_recipe(find_recipe(DEFAULT_RECIPE)), registry)
    problems = []
    with progress() as tell:
        for i in range(count):
            tell(f"problem {i + 1} of {count}: {level}, {movables} movables, seed {seed + i}")
            problem = generate_shelf(
                movables=movables, seed=seed + i, level=level, classify=classify
            )
            problems.append(problem)
    write_problems(problems, output)
