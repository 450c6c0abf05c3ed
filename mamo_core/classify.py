"""The class of a problem: how many movables are in the way of a canonical retrieval."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mamo_core.compose import build_parts, choose
from mamo_core.errors import InputError
from mamo_core.plugins import Registry
from mamo_core.problems.generator import LEVELS, level_of
from mamo_core.recipes import LoadedRecipe
from mamo_core.types.problem import Problem

RETRIEVAL_ROLES = ("kinematics", "collision", "arm_planner", "retrieval")
CLASSES = ("none", *LEVELS, "unreachable", "unknown")
"""Unreachable: not even without movables; unknown: it could not be found out."""


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


def class_of(in_the_way: int | None) -> str:
    """Class by the number of movables in the initial NGR of one canonical, seeded retrieval."""
    if in_the_way is None:
        return "unreachable"
    return level_of(in_the_way) or "none"
