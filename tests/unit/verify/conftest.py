"""A small shelf with one movable in the way, and a plan for it, made once."""

from pathlib import Path

import pytest

from mamo_core.compose import compose
from mamo_core.plugins import discover
from mamo_core.problems import load_problem
from mamo_core.recipe_sets import apply_sets
from mamo_core.recipes import find_recipe, load_recipe
from mamo_core.types.solution import SolutionStatus

SMALL = Path(__file__).parents[2] / "golden" / "small_shelf.yaml"
"""A wide box right in front of the target, a post and a box beside."""


@pytest.fixture(scope="session")
def problem():
    return load_problem(SMALL)


@pytest.fixture(scope="session")
def planner(problem):
    return composed(problem)


def composed(problem, *settings):
    """M4M for a problem, with settings as after ``--set``."""
    recipe = apply_sets(find_recipe("m4m"), ["search.attempts=20", *settings])
    return compose(load_recipe(recipe), problem, discover())


@pytest.fixture(scope="session")
def compose_for():
    return composed


@pytest.fixture(scope="session")
def plan(planner):
    solution = planner.solve(seed=0)
    assert solution.status is SolutionStatus.SOLVED, solution.reason
    assert solution.plan.actions, "nothing had to be moved: the tests need an action"
    return solution.plan
