"""What this package adds to mamo: the search ``my_search``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from mamo_core.hookspecs import Component, hookimpl
from mamo_my_search.search import MySearch, MySearchOptions

if TYPE_CHECKING:
    from mamo_core.build_context import BuildContext


def build(context: BuildContext, options: MySearchOptions) -> MySearch:
    """The search for one problem, made of the parts that the recipe chose."""
    return MySearch(
        problem=context.problem,
        robot=context.robot,
        backend=context.part("backend"),
        collision=context.part("collision"),
        arm_planner=context.part("arm_planner"),
        retrieval=context.part("retrieval"),
        actions=context.actions,
        verifier=context.part("verifier"),
        options=options,
    )


@hookimpl
def mamo_searches() -> Iterable[Component]:
    """Called by mamo when it looks for searches."""
    needed = ("backend", "collision", "arm_planner", "retrieval", "action")
    return [
        Component(
            name="my_search",
            build=build,
            options=MySearchOptions,
            summary="depth-first: retrieve, or move one more object out of the way",
            requires={role: frozenset() for role in needed},
        )
    ]
