"""Table of contents of the planners: what is registered, and how it is put together."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from mamo_core.hookspecs import Component, NoOptions, hookimpl
from mamo_core.types.deviation import Deviation
from mamo_core.types.search_graph import KEEPS_GRAPHS
from mamo_planners.baselines.options import DogarOptions, SelectiveSimulationOptions
from mamo_planners.baselines.sampling.components import components as sampling_components
from mamo_planners.mapf.components import COMPONENTS as MAPF_COMPONENTS
from mamo_planners.options import PickPlaceOptions, PushOptions, RetrievalOptions, TurnOptions
from mamo_planners.reaching.options import ArmLatticeOptions, SpampOptions
from mamo_planners.search.options import (
    BestFirstOptions,
    DepthFirstOptions,
    GreedyOptions,
    Nearby,
    Uncertainty,
)

if TYPE_CHECKING:
    import numpy as np

    from mamo_core.build_context import BuildContext
    from mamo_core.cli.workbench import Workbench
    from mamo_core.interfaces.transition_model import Replay
    from mamo_core.types.motion import Motion, MotionSegment
    from mamo_core.types.scene import SceneState
    from mamo_core.types.solution import Budget, Statistics
    from mamo_planners.reaching.stand import ReachingParts
    from mamo_planners.search.run import SearchParts

_REACHES = frozenset({"reach", "retrieve"})
_CONTINUED = {"backend": frozenset({"exact_continuation"})}
_MAPF = {**_CONTINUED, "mapf": frozenset[str]()}


def _arm_parts(context: BuildContext) -> tuple[Any, Any, Any, Any, Any]:
    """What everything that moves the arm starts with."""
    return (
        context.problem,
        context.robot,
        context.part("kinematics"),
        context.part("collision"),
        context.part("arm_planner"),
    )


def _retrieval(context: BuildContext, options: RetrievalOptions) -> Any:
    from mamo_planners.retrieval import GraspAndExtract

    return GraspAndExtract(*_arm_parts(context), options)


def _push(context: BuildContext, options: PushOptions) -> Any:
    from mamo_planners.actions.push import Push

    return Push(*_arm_parts(context), options)


def _turn(context: BuildContext, options: TurnOptions) -> Any:
    from mamo_planners.actions.push import Push
    from mamo_planners.actions.turn import Turn

    pushes = PushOptions(samples=options.per_line)
    return Turn(context.problem, Push(*_arm_parts(context), pushes, kind="turn"), options)


def _pick_place(context: BuildContext, options: PickPlaceOptions) -> Any:
    from mamo_planners.actions.pick_place import PickPlace

    return PickPlace(*_arm_parts(context), options)


def _search_parts(
    context: BuildContext, uncertainty: Uncertainty | None = None, nearby: Nearby | None = None
) -> SearchParts:
    """``nearby``: with what room actions must hold in worlds close to the problem's, too."""
    from mamo_core.robots.contact_free import check_meshes
    from mamo_core.robots.exact_collision import ExactChecker
    from mamo_core.robots.passage import passes
    from mamo_planners.search.clearance import keeps_clear
    from mamo_planners.search.execution import Execution
    from mamo_planners.search.run import SearchParts
    from mamo_planners.search.stand import Engine
    from mamo_planners.search.uncertainty import needed, sampled, stricter

    problem, robot = context.problem, context.robot
    scene, collision = problem.scene, context.part("collision")
    clear = partial(keeps_clear, problem, context.part("kinematics"), collision)

    def contact_free(motion: Motion, states: Sequence[SceneState]) -> bool:
        return not check_meshes(scene, motion.segments, states, robot, motion.opening)

    exact = ExactChecker(scene, robot)

    def passing(segments: Sequence[MotionSegment], state: SceneState, opening: float) -> bool:
        # What the quick one calls free, the exact one does, too.
        return any(
            passes(checker, scene, robot, segments, state, opening)
            for checker in (collision, exact)
        )

    backend = quick = context.part("backend")
    strict = stricter(problem, uncertainty) if uncertainty is not None else problem
    if strict is not problem:
        backend = quick = context.part("engine_for")(strict)
    replays = _replays(context, nearby) if nearby is not None else ()
    if uncertainty is not None and uncertainty.backend:
        quick = context.part("engine_for")(strict, uncertainty.backend)

    def engines(rng: np.random.Generator) -> tuple[Engine, list[Engine], int]:
        """What tries actions, what executes them, the first continuously, and how many may fail."""
        others = [Engine(name, model) for name, model in context.accept_in]
        if uncertainty is None:
            own = Engine("backend", backend)
            trial = replays[0].model if replays else backend
            return replace(own, model=trial, continuous=False), [own, *others], 0
        values = sampled(scene, uncertainty, rng)
        samples = [Engine(f"sample_{n}", quick, v, continuous=False) for n, v in enumerate(values)]
        leading = replace(samples[0], model=backend, continuous=True)
        tolerated = len(samples) - needed(uncertainty.threshold, len(samples))
        return samples[0], [leading, *samples[1:], *others], tolerated

    def execution(statistics: Statistics, budget: Budget, rng: np.random.Generator) -> Execution:
        trial, used, tolerated = engines(rng)
        return Execution(
            problem,
            robot,
            trial,
            used,
            replays,
            collision,
            context.part("arm_planner"),
            contact_free,
            clear,
            passing,
            statistics,
            budget,
            tolerated,
            uncertainty.safety_margin if uncertainty is not None else 0.0,
        )

    return SearchParts(
        context.problem,
        context.part("retrieval"),
        context.mapf,
        context.actions,
        execution,
        partial(context.part("verifier"), replays=False, friction=nearby is not None),
    )


def _replays(context: BuildContext, nearby: Nearby) -> tuple[Replay, ...]:
    from mamo_planners.search.uncertainty import stricter

    wider = Deviation(nearby.deviation, math.radians(nearby.deviation_deg))
    strict = stricter(context.problem, nearby)
    found: tuple[Replay, ...] = context.part("replays")(strict, wider, nearby.worlds)
    return found


def _greedy(context: BuildContext, options: GreedyOptions) -> Any:
    from mamo_planners.search.greedy import GreedySearch

    return GreedySearch(_search_parts(context, nearby=options.nearby), options)


def _depth_first(context: BuildContext, options: DepthFirstOptions) -> Any:
    from mamo_planners.search.orders import DepthFirst
    from mamo_planners.search.rearrangement import RearrangementSearch

    parts = _search_parts(context, options.uncertainty, options.nearby)
    return RearrangementSearch(parts, lambda problem, region: DepthFirst(), options)


def _best_first(context: BuildContext, options: BestFirstOptions) -> Any:
    from mamo_planners.search.orders import order_of
    from mamo_planners.search.rearrangement import RearrangementSearch

    return RearrangementSearch(
        _search_parts(context, options.uncertainty, options.nearby), order_of(options), options
    )


def _mha_star(context: BuildContext, options: ArmLatticeOptions) -> Any:
    from mamo_planners.reaching.arm_planner import MultiHeuristicAStar

    return MultiHeuristicAStar(context.problem, context.robot, context.part("kinematics"), options)


def _reaching_parts(context: BuildContext) -> ReachingParts:
    from mamo_planners.reaching.stand import ReachingParts

    return ReachingParts(*_arm_parts(context), context.part("backend"), context.part("verifier"))


def _spamp(context: BuildContext, options: SpampOptions) -> Any:
    from mamo_planners.reaching.spamp import Spamp

    return Spamp(_reaching_parts(context), options)


def _dogar(context: BuildContext, options: DogarOptions) -> Any:
    from mamo_planners.baselines.dogar import Dogar

    return Dogar(_search_parts(context), context.part("collision"), options)


def _selective_simulation(context: BuildContext, options: SelectiveSimulationOptions) -> Any:
    from mamo_planners.baselines.selective_simulation import SelectiveSimulation

    return SelectiveSimulation(_reaching_parts(context), context.part("engine_for"), options)


def _learn_priority(bench: Workbench, options: NoOptions) -> Any:
    from mamo_planners.learning.command import command_of

    return command_of(bench)


@hookimpl
def mamo_arm_planners() -> Iterable[Component]:
    """Multi-heuristic A*."""
    return [
        Component(
            "mha_star",
            _mha_star,
            ArmLatticeOptions,
            "multi-heuristic A* over joint primitives (thesis 3.4)",
        ),
    ]


@hookimpl
def mamo_retrieval_planners() -> Iterable[Component]:
    """Grasp, lift, extract, home."""
    return [
        Component(
            "grasp_and_extract",
            _retrieval,
            RetrievalOptions,
            "side grasps, lift, carry home",
            requires={"collision": frozenset({"hands_free", "swept_region"})},
        ),
    ]


@hookimpl
def mamo_mapf_solvers() -> Iterable[Component]:
    """Multi-agent pathfinding for true footprints."""
    return MAPF_COMPONENTS


@hookimpl
def mamo_actions() -> Iterable[Component]:
    """Pushes, and pick and place."""
    return [
        Component(
            "push",
            _push,
            PushOptions,
            "straight pushes, thesis 4.4.2 and richer",
            requires={"collision": frozenset({"hands_free"})},
        ),
        Component(
            "pick_place",
            _pick_place,
            PickPlaceOptions,
            "grasp, carry without contact, put down, thesis 6.3.1",
            requires={"collision": frozenset({"hands_free"})},
        ),
        Component(
            "turn",
            _turn,
            TurnOptions,
            "pushes beside the centre that turn a box out of the way",
            requires={"collision": frozenset({"hands_free"})},
        ),
    ]


@hookimpl
def mamo_searches() -> Iterable[Component]:
    """M4M, E-M4M and I-M4M."""
    return [
        Component(
            "greedy",
            _greedy,
            GreedyOptions,
            "M4M: commit to every valid push (thesis, Algorithm 4)",
            requires=_MAPF,
        ),
        Component(
            "best_first",
            _best_first,
            BestFirstOptions,
            "E-M4M: the most promising rearrangement first (thesis, Algorithm 5)",
            provides=frozenset({KEEPS_GRAPHS}),
            requires=_MAPF,
        ),
        Component(
            "depth_first",
            _depth_first,
            DepthFirstOptions,
            "I-M4M: the rearrangement with the most actions first, lazily if wanted (thesis 6.3)",
            provides=frozenset({KEEPS_GRAPHS}),
            requires=_MAPF,
        ),
        Component(
            "dogar",
            _dogar,
            DogarOptions,
            "backwards from the retrieval (Dogar and Srinivasa, 2012)",
            requires={**_CONTINUED, "action": frozenset[str]()},
        ),
        Component(
            "spamp",
            _spamp,
            SpampOptions,
            "SPAMP: pushes only in the last motion (thesis, Algorithms 2 and 3)",
            requires=_CONTINUED,
            tasks=_REACHES,
        ),
        Component(
            "selective_simulation",
            _selective_simulation,
            SelectiveSimulationOptions,
            "SelSim: simulates what was found to be in the way (Saleem and Likhachev, 2020)",
            requires=_CONTINUED,
            tasks=_REACHES,
        ),
        *sampling_components(_reaching_parts, _REACHES),
    ]


@hookimpl
def mamo_commands() -> Iterable[Component]:
    """Learning."""
    return [
        Component(
            "learn_priority",
            _learn_priority,
            summary="gathers data and fits the priority of E-M4M (thesis 5.5.3)",
        )
    ]


def warm_up() -> None:
    """Compile the kernels of MAPF and of SPAMP's heuristic (or read them from numba's cache)."""
    from mamo_planners.mapf import warm_up as compile_mapf
    from mamo_planners.reaching.distance_field import warm_up as compile_field

    compile_mapf()
    compile_field()
