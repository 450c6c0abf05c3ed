"""What this package adds to mamo."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from mamo_core.hookspecs import Component, hookimpl
from mamo_shove.shove import Shove, ShoveOptions

if TYPE_CHECKING:
    from mamo_core.compose import BuildContext


def _shove(context: BuildContext, options: ShoveOptions) -> Shove:
    # mamo has refused a recipe without these, because the component below requires them.
    assert context.kinematics is not None
    assert context.collision is not None
    assert context.arm_planner is not None
    return Shove(
        problem=context.problem,
        robot=context.robot,
        kinematics=context.kinematics,
        collision=context.collision,
        arm_planner=context.arm_planner,
        options=options,
    )


@hookimpl
def mamo_actions() -> Iterable[Component]:
    """The action ``shove``."""
    return [
        Component(
            name="shove",
            build=_shove,
            options=ShoveOptions,
            summary="push an object from a random side",
            requires={role: frozenset() for role in ("kinematics", "collision", "arm_planner")},
        )
    ]
