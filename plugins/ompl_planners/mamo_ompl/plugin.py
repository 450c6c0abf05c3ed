"""Registers the arm planners of OMPL, which is imported only when one of them is built."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING, Any

from mamo_core.hookspecs import Component, hookimpl
from mamo_ompl.kinds import KINDS, Kind
from mamo_ompl.options import OmplOptions

if TYPE_CHECKING:
    from mamo_core.build_context import BuildContext


def _arm_planner(kind: Kind, context: BuildContext, options: OmplOptions) -> Any:
    from mamo_ompl.arm_planner import OmplArmPlanner

    return OmplArmPlanner(context.robot, kind, options)


def _builder(kind: Kind) -> Callable[[Any, Any], Any]:
    return partial(_arm_planner, kind)


@hookimpl
def mamo_arm_planners() -> Iterable[Component]:
    """Those of the geometric planners of OMPL that are bound and work from Python."""
    return [
        Component(name, _builder(kind), kind.options, f"OMPL: {kind.summary}", extra="ompl")
        for name, kind in KINDS.items()
    ]
