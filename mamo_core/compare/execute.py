"""Executes a plan in an engine, as planned and from slightly different initial poses."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mamo_core.compare.divergence import compare_actions
from mamo_core.interfaces.transition_model import RolloutOptions, TransitionModel
from mamo_core.recording.tracks import align
from mamo_core.robots.model import ArmModel
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Plan
from mamo_core.verify import VerifyReport, verify

SHIFT = 1e-4
"""Initial positions are moved by up to this along x and y for the chaos floor, m."""


@dataclass(frozen=True, eq=False)
class Execution:
    """A plan in one engine: the verdict, with a recorded rollout, and the engine's chaos floor.

    ``floor`` (actions,): the most (m) that any object ends up elsewhere during an action, in the
    median over executions from initial poses moved by ``SHIFT``.
    """

    engine: str
    report: VerifyReport
    floor: tuple[float, ...]


def execute(
    engine: str,
    problem: Problem,
    plan: Plan,
    model: TransitionModel,
    robot: ArmModel,
    *,
    trace_step: float = 0.01,
    samples: int = 3,
    seed: int = 0,
) -> Execution:
    """Verify the plan in an engine, then execute it ``samples`` times from poses moved a little."""
    report = verify(problem, plan, model, robot, trace_step=trace_step)
    rollout = report.rollout
    if rollout is None or rollout.lost is not None:
        return Execution(engine, report, ())
    whole = Motion(tuple(s for m in plan.motions for s in m.segments), plan.motions[0].opening)
    options = RolloutOptions(stop_early=False, trace_step=trace_step)
    rng = np.random.default_rng(seed)
    moved = [
        model.rollout(shifted(problem.initial, rng), whole, options=options) for _ in range(samples)
    ]
    return Execution(engine, report, _floor(problem, plan, rollout, moved))


def shifted(state: SceneState, rng: np.random.Generator) -> SceneState:
    """The state with every object moved a little along x and y."""
    poses = np.array(state.object_poses)
    poses[:, :2] += rng.uniform(-SHIFT, SHIFT, size=(len(poses), 2))
    return replace(state, object_poses=poses)


def _floor(
    problem: Problem, plan: Plan, nominal: RolloutResult, moved: list[RolloutResult]
) -> tuple[float, ...]:
    pair = ("as planned", "shifted")
    rows: list[list[float]] = [[] for _ in plan.motions]
    for other in moved:
        if other.lost is not None:
            continue
        tracks = align(dict(zip(pair, (nominal, other), strict=True)))
        for comparison in compare_actions(problem.scene, plan.motions, tracks, pair):
            rows[comparison.action].append(comparison.apart)
    return tuple(float(np.median(row)) if row else float("nan") for row in rows)
