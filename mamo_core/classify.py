"""The class of a problem: how many movables are in the way of a canonical retrieval or reach."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mamo_core.build_context import BuildContext
from mamo_core.choices import choose
from mamo_core.compose import build_parts
from mamo_core.errors import InputError
from mamo_core.plugins import Registry
from mamo_core.problems.generator import LEVELS, level_of
from mamo_core.recipes import LoadedRecipe
from mamo_core.types.geometry import Array
from mamo_core.types.problem import Problem, Task
from mamo_core.types.region import SweptRegion

REACH_ROLES = ("kinematics", "collision", "arm_planner")
RETRIEVAL_ROLES = (*REACH_ROLES, "retrieval")
CLASSES = ("none", *LEVELS, "unreachable", "unknown")
"""Unreachable: not even without movables; unknown: it could not be found out."""

_BRANCHES = 32
"""Arm configurations tried for the pre-grasp pose of a reach."""


def make_classifier(recipe: LoadedRecipe, registry: Registry) -> Callable[[Problem], int | None]:
    """A function that counts the movables in the initial NGR of a problem.

    That is the region swept by a retrieval (thesis 4.4) or, where the task is to reach, by the
    arm on its way to a pre-grasp, the hand as open as the grasp wants it; both planned with the
    parts of the recipe, with seed 0, and with the movables ignored. It is None where even then
    there is no way. For a reach the recipe needs no retrieval planner.
    """

    def classify(problem: Problem) -> int | None:
        region = _region(recipe, problem, registry)
        if region is None:
            return None
        objects, poses = problem.scene.objects, problem.initial.object_poses
        return sum(
            region.overlaps(objects[i].shape, poses[i]) for i in problem.scene.movable_indices
        )

    return classify


def _region(recipe: LoadedRecipe, problem: Problem, registry: Registry) -> SweptRegion | None:
    reach = problem.task is Task.REACH
    choices = choose(recipe, problem, registry, REACH_ROLES if reach else RETRIEVAL_ROLES)
    context = build_parts(choices, problem)
    return _swept_by_reach(context) if reach else _swept_by_retrieval(context, recipe)


def _swept_by_retrieval(context: BuildContext, recipe: LoadedRecipe) -> SweptRegion | None:
    retrieval, state = context.retrieval, context.problem.initial
    if retrieval is None:
        raise InputError(f"recipe {recipe.recipe.name!r} has no retrieval planner")
    motion = retrieval.plan(state, np.random.default_rng(0), ignore_movables=True).motion
    return None if motion is None else retrieval.swept_region(state, motion)


def _swept_by_reach(context: BuildContext) -> SweptRegion | None:
    """By the way to the first of the pre-grasps there is one to."""
    rng = np.random.default_rng(0)
    problem = context.problem
    for grasp, T_world_tool in zip(problem.grasps, problem.pregrasps, strict=True):
        path = _reach(context, T_world_tool, grasp.opening, rng)
        if path is not None:
            region: SweptRegion = context.part("collision").swept_region(
                path, opening=grasp.opening
            )
            return region
    return None


def _reach(
    context: BuildContext, T_world_tool: Array, opening: float, rng: np.random.Generator
) -> Array | None:
    """A path (k, dof) from the initial configuration that touches neither the target nor anything
    else that cannot be moved."""
    scene, initial = context.problem.scene, context.problem.initial
    movables = [scene.objects[i].name for i in scene.movable_indices]
    world = context.part("collision").world(initial.object_poses, opening=opening, ignore=movables)
    goals = context.part("kinematics").inverse(T_world_tool, rng, count=_BRANCHES)
    goals = goals[world.free(goals)] if len(goals) else goals
    if not len(goals):
        return None
    planner = context.part("arm_planner")
    path: Array | None = planner.plan(initial.joint_positions, goals, world, rng).path
    return path


def class_of(in_the_way: int | None) -> str:
    """Class by the number of movables in the initial NGR of one canonical, seeded retrieval."""
    if in_the_way is None:
        return "unreachable"
    return level_of(in_the_way) or "none"
