"""The work behind ``mamo problem generate``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from mamo_core.cli.output import progress, warn_of_broken_plugins
from mamo_core.cli.problem_files import check_output, write_problems
from mamo_core.compose import build_parts, choose
from mamo_core.errors import InputError
from mamo_core.plugins import Registry, discover
from mamo_core.problems import generate_shelf
from mamo_core.recipes import DEFAULT_RECIPE, LoadedRecipe, find_recipe, load_recipe
from mamo_core.types.problem import Problem

RETRIEVAL_ROLES = ("kinematics", "collision", "arm_planner", "retrieval")


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


def make_classifier(recipe: LoadedRecipe, registry: Registry) -> Callable[[Problem], int | None]:
    """A function that counts the movables in the initial NGR of a problem.

    It is None where even without movables the target cannot be retrieved.
    """

    def classify(problem: Problem) -> int | None:
        choices = choose(recipe, problem, registry, RETRIEVAL_ROLES)
        retrieval = build_parts(choices, problem).retrieval
        if retrieval is None:
            raise InputError(f"recipe {recipe.recipe.name!r} has no retrieval planner")
        state = problem.initial
        motion = retrieval.plan(state, np.random.default_rng(0), ignore_movables=True).motion
        if motion is None:
            return None
        region = retrieval.swept_region(state, motion)
        objects = problem.scene.objects
        return sum(
            region.overlaps(objects[i].shape, state.object_poses[i])
            for i in problem.scene.movable_indices
        )

    return classify
