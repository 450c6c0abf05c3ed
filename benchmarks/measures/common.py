"""Scenes, planners and clocks that the measurements share."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mamo_core.build_context import BuildContext
from mamo_core.choices import choose
from mamo_core.compose import build_parts
from mamo_core.plugins import Registry
from mamo_core.problems import generate_shelf
from mamo_core.recipe_sets import chosen_recipe
from mamo_core.recipes import DEFAULT_RECIPE
from mamo_core.types.region import SweptRegion

FIRST_SEED = 1000
"""Seeds of the generated shelves: this one and those after it."""


@dataclass(frozen=True)
class Measured:
    """Figures by key, and in words how they came about."""

    values: dict[str, float]
    how: dict[str, str] = field(default_factory=dict)


def shelves(registry: Registry, movables: int, roles: tuple[str, ...]) -> Iterator[BuildContext]:
    """Generated shelves with so many movables, with those parts of the default planner."""
    recipe = chosen_recipe(DEFAULT_RECIPE)
    seed = FIRST_SEED
    while True:
        problem = generate_shelf(movables=movables, seed=seed)
        yield build_parts(choose(recipe, problem, registry, roles), problem)
        seed += 1


def initial_region(context: BuildContext) -> SweptRegion | None:
    """The space that a retrieval sweeps when movables are ignored; None if there is none."""
    retrieval, state = context.part("retrieval"), context.problem.initial
    motion = retrieval.plan(state, np.random.default_rng(0), ignore_movables=True).motion
    return None if motion is None else retrieval.swept_region(state, motion)


def cpu_seconds(call: Callable[[], Any]) -> float:
    """CPU seconds of one call."""
    started = time.process_time()
    call()
    return time.process_time() - started
