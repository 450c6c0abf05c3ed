"""Registers the MuJoCo backend; MuJoCo is imported only when it is built."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from mamo_core.hookspecs import Component, hookimpl
from mamo_mujoco.options import MuJoCoOptions

if TYPE_CHECKING:
    from mamo_core.compose import BuildContext


def _build(context: BuildContext, options: MuJoCoOptions) -> Any:
    from mamo_mujoco.model import MuJoCoModel

    return MuJoCoModel(context.problem, context.robot, context.constraints, options)


@hookimpl
def mamo_backends() -> Iterable[Component]:
    """MuJoCo, the default engine."""
    return [
        Component(
            "mujoco",
            _build,
            MuJoCoOptions,
            "MuJoCo with elliptic cones and the Newton solver",
            provides=frozenset(
                {
                    "batch",
                    "dynamics",
                    "exact_continuation",
                    "friction_product",
                    "parameter_overrides",
                    "tool_pose",
                }
            ),
        ),
    ]


def warm_up() -> None:
    """Compile the kernels (or read them from numba's cache)."""
    from mamo_mujoco.kernels import warm_up as compile_all

    compile_all()
