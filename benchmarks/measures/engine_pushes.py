"""The same pushes in several engines, beside what each engine does to a shift of 0.1 mm."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, islice

import numpy as np

from mamo_core.build_context import BuildContext
from mamo_core.choices import choose
from mamo_core.compare.execute import shifted
from mamo_core.compose import build_parts
from mamo_core.interfaces.transition_model import RolloutOptions, TransitionModel
from mamo_core.plugins import Registry
from mamo_core.recipe_sets import chosen_recipe
from mamo_core.study.problems import Picked
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import SceneState, displacements
from mamo_core.types.solution import Statistics
from measures.common import cpu_seconds
from measures.push import ROLES, requests

SHIFTS = 3
MOVED = 0.01
ALL = RolloutOptions(stop_early=False)


@dataclass(frozen=True, eq=False)
class PushRuns:
    """One push by engine: the result, results from shifted poses, and CPU seconds."""

    start: SceneState
    nominal: Mapping[str, RolloutResult]
    shifted: Mapping[str, Sequence[RolloutResult]]
    cpu: Mapping[str, float]


def engine_models(context: BuildContext, engines: Sequence[str]) -> dict[str, TransitionModel]:
    """A model of each engine in this process, with default options otherwise."""
    from mamo_core.plugins import discover

    registry, models = discover(), {}
    for name in engines:
        component = registry.component("backend", name, "--backends")
        workers = {"workers": 0} if "isolated" in component.provides else {}
        models[name] = component.build(context, component.options(**workers))
    return models


def run_pushes(
    picked: Sequence[Picked], registry: Registry, engines: Sequence[str], count: int
) -> Iterator[PushRuns]:
    """One push each, of those that are valid in the first engine, from so many problems."""
    for context, state, sweep in islice(_valid_pushes(picked, registry), count):
        models = engine_models(context, engines)
        rng = np.random.default_rng(0)
        states = [shifted(state, rng) for _ in range(SHIFTS)]
        timed = {name: _timed(model, state, sweep) for name, model in models.items()}
        moved = {
            name: [model.rollout(other, sweep, options=ALL) for other in states]
            for name, model in models.items()
        }
        nominal = {name: result for name, (result, _) in timed.items()}
        yield PushRuns(state, nominal, moved, {name: cpu for name, (_, cpu) in timed.items()})


def _timed(model: TransitionModel, state: SceneState, sweep: Motion) -> tuple[RolloutResult, float]:
    results: list[RolloutResult] = []
    cpu = cpu_seconds(lambda: results.append(model.rollout(state, sweep, options=ALL)))
    return results[0], cpu


def _valid_pushes(
    picked: Sequence[Picked], registry: Registry
) -> Iterator[tuple[BuildContext, SceneState, Motion]]:
    recipe = chosen_recipe("m4m")
    for entry in picked:
        problem, _ = entry.load()
        context = build_parts(choose(recipe, problem, registry, ROLES), problem)
        found = _first_valid(context)
        if found is not None:
            yield (context, *found)


def _first_valid(context: BuildContext) -> tuple[SceneState, Motion] | None:
    rng, initial = np.random.default_rng(0), context.problem.initial
    for request in requests(context, rng):
        for _, generator in context.actions:
            for action in generator.propose(initial, request, rng, Statistics()):
                sweep = action.motion.after_transit()
                state = initial.with_joints(sweep.start)
                result = context.part("backend").rollout(state, sweep)
                if result.valid and action.object_name in result.moved:
                    return state, sweep
    return None


def tables(runs: Sequence[PushRuns], engines: Sequence[str]) -> str:
    """Agreement of every two engines, each engine's chaos floor, and what a push costs."""
    lines = [
        "| engines | objects | median mm | p90 mm | same moved set % |",
        "|---|---|---|---|---|",
    ]
    for one, other in combinations(engines, 2):
        pairs = [(run.start, run.nominal[one], run.nominal[other]) for run in runs]
        lines.append(_agreement(f"{one} - {other}", pairs))
    for name in engines:
        pairs = [(run.start, run.nominal[name], m) for run in runs for m in run.shifted[name]]
        lines.append(_agreement(f"{name} - itself, poses moved by 0.1 mm", pairs))
    lines += ["", "| engine | median CPU s per push | times the first |", "|---|---|---|"]
    first = float(np.median([run.cpu[engines[0]] for run in runs]))
    for name in engines:
        median = float(np.median([run.cpu[name] for run in runs]))
        lines.append(f"| {name} | {median:.4f} | {median / first:.1f} |")
    return "\n".join(lines)


def _agreement(label: str, pairs: Sequence[tuple[SceneState, RolloutResult, RolloutResult]]) -> str:
    gaps = np.concatenate([_gaps(*pair) for pair in pairs])
    same = np.mean([set(one.moved) == set(other.moved) for _, one, other in pairs])
    median, p90 = np.quantile(1e3 * gaps, [0.5, 0.9])
    return f"| {label} | {len(gaps)} | {median:.1f} | {p90:.1f} | {100 * same:.0f} |"


def _gaps(start: SceneState, one: RolloutResult, other: RolloutResult) -> Array:
    """Distances (m) of the final positions of what moved in either."""
    moved = np.maximum(
        displacements(start, one.final_state), displacements(start, other.final_state)
    )
    return displacements(one.final_state, other.final_state)[moved > MOVED]
