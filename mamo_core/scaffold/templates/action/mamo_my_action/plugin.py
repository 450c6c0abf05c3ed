"""What this package adds to mamo: the action ``my_action``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from mamo_core.hookspecs import Component, hookimpl
from mamo_my_action.action import MyAction, MyActionOptions

if TYPE_CHECKING:
    from mamo_core.build_context import BuildContext


def build(context: BuildContext, options: MyActionOptions) -> MyAction:
    """The action for one problem, made of the parts that the recipe chose."""
    return MyAction(
        problem=context.problem,
        robot=context.robot,
        kinematics=context.part("kinematics"),
        collision=context.part("collision"),
        arm_planner=context.part("arm_planner"),
        options=options,
    )


@hookimpl
def mamo_actions() -> Iterable[Component]:
    """Called by mamo when it looks for actions."""
    return [
        Component(
            name="my_action",
            build=build,
            options=MyActionOptions,
            summary="straight pushes along the way an object should go",
            requires={role: frozenset() for role in ("kinematics", "collision", "arm_planner")},
        )
    ]
