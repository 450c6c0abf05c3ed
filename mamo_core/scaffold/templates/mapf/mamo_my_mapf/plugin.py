"""What this package adds to mamo: the pathfinding solver ``my_mapf``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from mamo_core.hookspecs import Component, hookimpl
from mamo_my_mapf.mapf import MyMapf, MyMapfOptions

if TYPE_CHECKING:
    from mamo_core.build_context import BuildContext


def build(context: BuildContext, options: MyMapfOptions) -> MyMapf:
    """The solver; it needs no other part, as it knows footprints and no physics."""
    return MyMapf(options)


@hookimpl
def mamo_mapf_solvers() -> Iterable[Component]:
    """Called by mamo when it looks for pathfinding solvers."""
    return [
        Component(
            name="my_mapf",
            build=build,
            options=MyMapfOptions,
            summary="one agent after the other; who finds no way goes first the next time",
        )
    ]
