"""What a step may show without several constraints having to look closer, in one glance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.types.geometry import Array, BoolArray
from mamo_core.types.problem import Problem


@dataclass(frozen=True, eq=False)
class Limits:
    """A step within these limits cannot break the constraint that has them.

    Of objects: ``lowest`` (n,), the least heights of their centres, m; ``axes`` (n, 3), what their
    z axes are compared with, and ``cosine``, the least of the angle between; ``square``, the
    largest of their speeds, m^2/s^2. ``forbidden`` (1 + n, e, e): pairs of entity numbers, in
    ascending order, that may not touch: while nothing is held, while object 0 is held, and so on.
    ``deepest``: how far things may reach into each other, m.
    """

    lowest: Array
    axes: Array
    cosine: float
    square: float
    forbidden: BoolArray
    deepest: float


class LimitedConstraint(InteractionConstraint):
    """A constraint that need not be asked about steps within its ``limits``.

    A subclass that allows less than its parent has narrower limits, too.
    """

    limits: Limits


def unlimited(problem: Problem) -> Limits:
    """Everything is allowed."""
    objects, entities = len(problem.scene.objects), len(problem.scene.entities)
    return Limits(
        lowest=np.full(objects, -np.inf),
        axes=problem.initial_z_axes,
        cosine=-np.inf,
        square=np.inf,
        forbidden=np.zeros((1 + objects, entities, entities), dtype=np.bool_),
        deepest=np.inf,
    )


def tightest(limits: Sequence[Limits]) -> Limits:
    """Within these a step is within all of some limits of one problem (at least one)."""
    return Limits(
        lowest=np.max([one.lowest for one in limits], axis=0),
        axes=limits[0].axes,
        cosine=max(one.cosine for one in limits),
        square=min(one.square for one in limits),
        forbidden=np.any([one.forbidden for one in limits], axis=0),
        deepest=min(one.deepest for one in limits),
    )
