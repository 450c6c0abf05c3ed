"""Registers the DART backend; DART is imported only when it is built."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING, Any

from mamo_core.hookspecs import Component, hookimpl
from mamo_dart.options import DARTOptions

if TYPE_CHECKING:
    from mamo_core.build_context import BuildContext


def _build(context: BuildContext, options: DARTOptions) -> Any:
    from mamo_core.simulation.isolated import isolated
    from mamo_dart.model import make_model

    make = partial(make_model, context.problem, context.robot, context.constraints, options)
    return isolated(make, options.workers, options.patience)


_CONTACT_CHECKS = (
    "robot_touches_immovable",
    "robot_touches_target",
    "robot_touches_fixture",
    "object_touches_immovable",
    "object_touches_target",
)
_ONSET = "contacts shorter than 20 ms may be missed"


@hookimpl
def mamo_backends() -> Iterable[Component]:
    """DART."""
    return [
        Component(
            "dart",
            _build,
            DARTOptions,
            "DART with ODE collision and NSGS contacts",
            provides=frozenset(
                {
                    "batch",
                    "dynamics",
                    "exact_continuation",
                    "isolated",
                    "parameter_overrides",
                    "self_contact",
                    "tool_pose",
                }
            ),
            extra="dart",
            cost=16.0,
            grades=dict.fromkeys(_CONTACT_CHECKS, _ONSET),
        ),
    ]
