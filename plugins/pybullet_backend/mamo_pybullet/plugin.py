"""Registers the PyBullet backend; PyBullet is imported only when it is built."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING, Any

from mamo_core.hookspecs import Component, hookimpl
from mamo_pybullet.options import PyBulletOptions

if TYPE_CHECKING:
    from mamo_core.build_context import BuildContext


def _build(context: BuildContext, options: PyBulletOptions) -> Any:
    from mamo_core.simulation.isolated import isolated
    from mamo_pybullet.model import make_model

    make = partial(make_model, context.problem, context.robot, context.constraints, options)
    return isolated(make, options.workers, options.patience)


@hookimpl
def mamo_backends() -> Iterable[Component]:
    """PyBullet."""
    return [
        Component(
            "pybullet",
            _build,
            PyBulletOptions,
            "PyBullet with friction cones; its world is rebuilt for every rollout",
            provides=frozenset(
                {
                    "batch",
                    "dynamics",
                    "exact_continuation",
                    "friction_product",
                    "isolated",
                    "parameter_overrides",
                    "self_contact",
                    "tool_pose",
                }
            ),
            extra="pybullet",
            cost=4.0,
        ),
    ]
