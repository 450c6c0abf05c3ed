"""What is registered of the sampling-based baselines; OMPL is imported only by what needs it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from mamo_core.hookspecs import Component
from mamo_planners.baselines.sampling.options import K3Options, KpieceOptions, RrtOptions

if TYPE_CHECKING:
    from mamo_core.build_context import BuildContext
    from mamo_core.types.solution import Plan
    from mamo_planners.baselines.sampling.growth import Growth, Node
    from mamo_planners.reaching.stand import ReachingParts

PartsOf = Callable[["BuildContext"], "ReachingParts"]


def components(parts_of: PartsOf, tasks: frozenset[str]) -> list[Component]:
    """K1, K2, K3 and RRT; ``parts_of`` gives what planners that reach work with."""
    continued = {"backend": frozenset({"exact_continuation"})}
    return [
        Component(
            "kpiece",
            partial(_kpiece, parts_of),
            KpieceOptions,
            "OMPL's KPIECE over arm and objects (thesis 3.5.1: K1, K2)",
            requires=continued,
            tasks=tasks,
            extra="ompl",
        ),
        Component(
            "k3",
            partial(_k3, parts_of),
            K3Options,
            "KPIECE that simulates only what touches something (thesis 3.5.1: K3)",
            requires=continued,
            tasks=tasks,
        ),
        Component(
            "rrt",
            partial(_rrt, parts_of),
            RrtOptions,
            "OMPL's RRT over arm and objects (thesis 5.6.1)",
            requires=continued,
            tasks=tasks,
            extra="ompl",
        ),
    ]


def _kpiece(parts_of: PartsOf, context: BuildContext, options: KpieceOptions) -> Any:
    from mamo_planners.baselines.sampling.actions import Actions, goals_before, goals_online
    from mamo_planners.baselines.sampling.control import grown
    from mamo_planners.baselines.sampling.search import SamplingSearch

    def grow(growth: Growth, root: Node) -> Plan | None:
        if options.variant == "k1":
            next_goal = goals_before(growth.goals, options.goals, growth.rng)
        else:
            next_goal = goals_online(growth.goals, growth.rng)
        return grown("KPIECE1", Actions(growth, [root], next_goal), options.cell)

    return SamplingSearch(parts_of(context), options, grow)


def _k3(parts_of: PartsOf, context: BuildContext, options: K3Options) -> Any:
    from mamo_planners.baselines.sampling.k3 import k3
    from mamo_planners.baselines.sampling.search import SamplingSearch

    return SamplingSearch(parts_of(context), options, partial(k3, options=options))


def _rrt(parts_of: PartsOf, context: BuildContext, options: RrtOptions) -> Any:
    from mamo_planners.baselines.sampling.actions import Actions, goals_before
    from mamo_planners.baselines.sampling.control import grown
    from mamo_planners.baselines.sampling.search import SamplingSearch

    def grow(growth: Growth, root: Node) -> Plan | None:
        next_goal = goals_before(growth.goals, options.goals, growth.rng)
        return grown("RRT", Actions(growth, [root], next_goal))

    return SamplingSearch(parts_of(context), options, grow)
