"""Registers the standard interaction constraints; their code is imported when one is built."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from mamo_core.constraints.options import (
    BoundsOptions,
    ContactOptions,
    PenetrationOptions,
    SpeedOptions,
    TiltOptions,
)
from mamo_core.hookspecs import Component, hookimpl

if TYPE_CHECKING:
    from mamo_core.build_context import BuildContext


def _contact(context: BuildContext, options: ContactOptions) -> Any:
    from mamo_core.constraints.standard import ContactConstraint

    return ContactConstraint(context.problem, options.clearance)


def _tilt(context: BuildContext, options: TiltOptions) -> Any:
    from mamo_core.constraints.standard import TiltConstraint

    return TiltConstraint(context.problem, options)


def _speed(context: BuildContext, options: SpeedOptions) -> Any:
    from mamo_core.constraints.standard import SpeedConstraint

    return SpeedConstraint(context.problem, options)


def _bounds(context: BuildContext, options: BoundsOptions) -> Any:
    from mamo_core.constraints.standard import BoundsConstraint

    return BoundsConstraint(context.problem, options)


def _penetration(context: BuildContext, options: PenetrationOptions) -> Any:
    from mamo_core.constraints.standard import PenetrationConstraint

    return PenetrationConstraint(context.problem, options)


@hookimpl
def mamo_constraints() -> Iterable[Component]:
    """Contact, tilt, speed, bounds and penetration."""
    return [
        Component("contact", _contact, ContactOptions, "no contact with immovables or the target"),
        Component("tilt", _tilt, TiltOptions, "objects stay upright"),
        Component("speed", _speed, SpeedOptions, "objects stay slow"),
        Component("bounds", _bounds, BoundsOptions, "objects do not fall"),
        Component(
            "penetration", _penetration, PenetrationOptions, "nothing is pressed into anything"
        ),
    ]


def warm_up() -> None:
    """Compile the screens (or read them from numba's cache)."""
    from mamo_core.constraints.kernels import warm_up as compile_all

    compile_all()
