"""Registers the standard interaction constraints."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from mamo_core.constraints.standard import (
    BoundsConstraint,
    BoundsOptions,
    ContactConstraint,
    ContactOptions,
    SpeedConstraint,
    SpeedOptions,
    TiltConstraint,
    TiltOptions,
)
from mamo_core.hookspecs import Component, hookimpl

if TYPE_CHECKING:
    from mamo_core.compose import BuildContext


def _contact(context: BuildContext, options: ContactOptions) -> ContactConstraint:
    return ContactConstraint(context.problem)


def _tilt(context: BuildContext, options: TiltOptions) -> TiltConstraint:
    return TiltConstraint(context.problem, options)


def _speed(context: BuildContext, options: SpeedOptions) -> SpeedConstraint:
    return SpeedConstraint(context.problem, options)


def _bounds(context: BuildContext, options: BoundsOptions) -> BoundsConstraint:
    return BoundsConstraint(context.problem, options)


@hookimpl
def mamo_constraints() -> Iterable[Component]:
    """Contact, tilt, speed and bounds."""
    return [
        Component("contact", _contact, ContactOptions, "no contact with immovables or the target"),
        Component("tilt", _tilt, TiltOptions, "objects stay upright"),
        Component("speed", _speed, SpeedOptions, "objects stay slow"),
        Component("bounds", _bounds, BoundsOptions, "objects do not fall"),
    ]
