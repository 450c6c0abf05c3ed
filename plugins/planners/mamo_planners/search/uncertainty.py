"""Masses and frictions that are not known exactly (thesis 6.3.4)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from statistics import NormalDist
from typing import Any

import numpy as np

from mamo_core.constraints.options import (
    ContactOptions,
    PenetrationOptions,
    SpeedOptions,
    TiltOptions,
)
from mamo_core.types.geometry import Array
from mamo_core.types.problem import ConstraintSpec, Problem
from mamo_core.types.rollout import ParameterOverrides
from mamo_core.types.scene import Mobility, Scene
from mamo_planners.search.options import Room, Uncertainty

_LEAST = 1e-12
"""Shares this close to 0 or 1 are as good: what is drawn is clipped long before."""


def sampled(
    scene: Scene, uncertainty: Uncertainty, rng: np.random.Generator
) -> list[ParameterOverrides]:
    """Values for all objects that can move, as often as there are samples.

    Normal around the problem's own, between half and twice of it.
    """
    loose = [o for o in scene.objects if o.mobility is not Mobility.IMMOVABLE]
    own = np.array([[o.mass for o in loose], [o.friction for o in loose]])
    spreads = np.array([[uncertainty.mass_spread], [uncertainty.friction_spread]])
    shape = (uncertainty.samples, *own.shape)
    drawn = _stratified(shape, rng) if uncertainty.stratified else rng.standard_normal(shape)
    values = np.clip(own + spreads * own * drawn, 0.5 * own, 2.0 * own)
    names = [o.name for o in loose]
    return [
        ParameterOverrides(*(dict(zip(names, row.tolist(), strict=True)) for row in sample))
        for sample in values
    ]


def _stratified(shape: tuple[int, ...], rng: np.random.Generator) -> Array:
    """Standard normal values: along the first axis one of each equally likely part."""
    count = shape[0]
    parts = rng.permuted(np.broadcast_to(np.arange(count)[:, None, None], shape), axis=0)
    shares = np.clip((parts + rng.random(shape)) / count, _LEAST, 1.0 - _LEAST)
    values: Array = np.vectorize(NormalDist().inv_cdf, otypes=[np.float64])(shares)
    return values


def needed(threshold: float, count: int) -> int:
    """How many of ``count`` samples must be valid for an action, or a plan, to be."""
    return max(1, math.floor(threshold * count + 1e-9))


def stricter(problem: Problem, room: Room) -> Problem:
    """The problem with limits that leave some room; itself if they are the same."""
    if room.clearance == 0.0 and room.limit_share == 1.0:
        return problem
    specs = tuple(
        replace(spec, options={**spec.options, **_stricter(spec, room)})
        for spec in problem.constraints
    )
    return replace(problem, constraints=specs)


def _stricter(spec: ConstraintSpec, room: Room) -> Mapping[str, Any]:
    """The options of a constraint that are others where room is to be left."""
    match spec.name:
        case "contact":
            own = ContactOptions(**spec.options).clearance
            return {"clearance": max(own, room.clearance)}
        case "tilt":
            return {"limit_deg": room.limit_share * TiltOptions(**spec.options).limit_deg}
        case "speed":
            return {"limit": room.limit_share * SpeedOptions(**spec.options).limit}
        case "penetration":
            return {"limit": room.limit_share * PenetrationOptions(**spec.options).limit}
        case _:
            return {}
