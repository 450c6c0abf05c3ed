"""One plan in several engines, and the sum over many plans."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import combinations

from mamo_core.compare.divergence import ActionComparison, compare_actions
from mamo_core.compare.execute import Execution, execute
from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.recording.tracks import Tracks, align
from mamo_core.robots.model import ArmModel
from mamo_core.types.problem import Problem
from mamo_core.types.solution import Plan


@dataclass(frozen=True, eq=False)
class PlanComparison:
    """A plan made with ``planned_with`` in every engine.

    ``actions``: for each pair of engines and each action. ``tracks``: all recorded executions on
    one grid; None if fewer than two engines gave one.
    """

    problem: Problem
    plan: Plan
    planned_with: str
    executions: tuple[Execution, ...]
    actions: tuple[ActionComparison, ...]
    tracks: Tracks | None

    def floor(self, engine: str, action: int) -> float:
        """The engine's own chaos floor during an action, m; nan if it has none."""
        floors = {e.engine: e.floor for e in self.executions}[engine]
        return floors[action] if action < len(floors) else float("nan")


def compare_plan(
    problem: Problem,
    plan: Plan,
    planned_with: str,
    models: Mapping[str, TransitionModel],
    robot: ArmModel,
    *,
    samples: int = 3,
    trace_step: float = 0.01,
) -> PlanComparison:
    """Execute the plan in every engine and find where each two of them part."""
    executions = tuple(
        execute(name, problem, plan, model, robot, samples=samples, trace_step=trace_step)
        for name, model in models.items()
    )
    rollouts = {e.engine: e.report.rollout for e in executions}
    recorded = {n: r for n, r in rollouts.items() if r is not None and r.lost is None}
    if len(recorded) < 2:
        return PlanComparison(problem, plan, planned_with, executions, (), None)
    tracks = align(recorded)
    actions = [
        comparison
        for pair in combinations(recorded, 2)
        for comparison in compare_actions(problem.scene, plan.motions, tracks, pair)
    ]
    return PlanComparison(problem, plan, planned_with, executions, tuple(actions), tracks)


@dataclass
class Transfer:
    """How plans of one engine fare in another: ``kinds`` of failures, plans counted once each."""

    plans: int = 0
    valid: int = 0
    kinds: Counter[str] = field(default_factory=Counter)


def transfer_matrix(comparisons: Iterable[PlanComparison]) -> dict[tuple[str, str], Transfer]:
    """By (planned with, executed in)."""
    matrix: dict[tuple[str, str], Transfer] = {}
    for comparison in comparisons:
        for execution in comparison.executions:
            key = comparison.planned_with, execution.engine
            cell = matrix.setdefault(key, Transfer())
            cell.plans += 1
            cell.valid += execution.report.ok
            cell.kinds.update(execution.report.kinds)
    return matrix
