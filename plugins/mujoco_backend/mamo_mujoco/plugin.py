"""Registers the MuJoCo backend; MuJoCo is imported only when it is built."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from mamo_core.errors import PluginError
from mamo_core.hookspecs import Component, NoOptions, hookimpl
from mamo_mujoco.options import MuJoCoOptions

if TYPE_CHECKING:
    from mamo_core.build_context import BuildContext


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
                    "clearance",
                    "dynamics",
                    "exact_continuation",
                    "friction_grasps",
                    "friction_product",
                    "parameter_overrides",
                    "self_contact",
                    "tool_pose",
                }
            ),
        ),
    ]


def _build_renderer(context: BuildContext, options: NoOptions) -> Any:
    try:
        from mamo_mujoco.rendering import MuJoCoRenderer
    except (RuntimeError, AttributeError) as error:  # of MuJoCo, which reads it when imported
        chosen = os.environ.get("MUJOCO_GL", "")
        raise PluginError(
            f"renderer 'mujoco' cannot be loaded: MUJOCO_GL={chosen}: {error}; "
            "unset it, or set it to egl or osmesa"
        ) from error
    return MuJoCoRenderer(context.robot)


@hookimpl
def mamo_renderers() -> Iterable[Component]:
    """MuJoCo's renderer, for recordings of any engine."""
    return [Component("mujoco", _build_renderer, summary="OpenGL without a screen: EGL or OSMesa")]


def warm_up() -> None:
    """Compile the kernels (or read them from numba's cache)."""
    from mamo_mujoco import kernels, loop

    kernels.warm_up()
    loop.warm_up()
