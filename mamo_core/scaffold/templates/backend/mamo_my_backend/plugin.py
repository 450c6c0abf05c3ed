"""What this package adds to mamo: the physics engine ``my_backend``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from mamo_core.hookspecs import Component, hookimpl
from mamo_my_backend.options import MyBackendOptions

if TYPE_CHECKING:
    from mamo_core.build_context import BuildContext
    from mamo_core.simulation.model import SimulatedModel


def build(context: BuildContext, options: MyBackendOptions) -> SimulatedModel:
    """The engine for one problem; what is slow to import is imported here."""
    from mamo_core.simulation.model import SimulatedModel
    from mamo_my_backend.backend import MyBackend

    problem, robot = context.problem, context.robot
    return SimulatedModel(
        problem,
        robot,
        context.constraints,
        lambda parameters: MyBackend(problem, robot, parameters, options),
    )


@hookimpl
def mamo_backends() -> Iterable[Component]:
    """Called by mamo when it looks for engines.

    ``provides`` says what the engine promises, and ``mamo plugins check`` holds it to that. With
    real physics add "dynamics", and "friction_product" if frictions of a pair are multiplied.
    """
    return [
        Component(
            name="my_backend",
            build=build,
            options=MyBackendOptions,
            summary="quasi-static pushing in the plane",
            provides=frozenset({"exact_continuation", "parameter_overrides", "tool_pose"}),
        )
    ]
