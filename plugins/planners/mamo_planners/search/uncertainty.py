"""Masses and frictions that are not known exactly (thesis 6.3.4)."""

from __future__ import annotations

import math

import numpy as np

from mamo_core.types.rollout import ParameterOverrides
from mamo_core.types.scene import Mobility, Scene
from mamo_planners.search.options import Uncertainty


def sampled(
    scene: Scene, uncertainty: Uncertainty, rng: np.random.Generator, count: int
) -> list[ParameterOverrides]:
    """Values for all objects that can move, ``count`` times.

    Normal around the problem's own, between half and twice of it.
    """
    loose = [o for o in scene.objects if o.mobility is not Mobility.IMMOVABLE]
    return [
        ParameterOverrides(
            {o.name: _drawn(o.mass, uncertainty.mass_spread, rng) for o in loose},
            {o.name: _drawn(o.friction, uncertainty.friction_spread, rng) for o in loose},
        )
        for _ in range(count)
    ]


def needed(threshold: float, count: int) -> int:
    """How many of ``count`` samples must be valid for an action, or a plan, to be."""
    return max(1, math.floor(threshold * count + 1e-9))


def _drawn(value: float, spread: float, rng: np.random.Generator) -> float:
    return float(np.clip(rng.normal(value, spread * value), 0.5 * value, 2.0 * value))
