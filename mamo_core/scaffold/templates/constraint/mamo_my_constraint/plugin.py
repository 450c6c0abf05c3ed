"""What this package adds to mamo: the constraint ``my_constraint``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from mamo_core.hookspecs import Component, hookimpl
from mamo_my_constraint.constraint import MyConstraint, MyConstraintOptions

if TYPE_CHECKING:
    from mamo_core.build_context import BuildContext


def build(context: BuildContext, options: MyConstraintOptions) -> MyConstraint:
    """The constraint for one problem."""
    return MyConstraint(context.problem, options)


@hookimpl
def mamo_constraints() -> Iterable[Component]:
    """Called by mamo when it looks for constraints."""
    return [
        Component(
            name="my_constraint",
            build=build,
            options=MyConstraintOptions,
            summary="movable objects stay near where they stood",
        )
    ]
