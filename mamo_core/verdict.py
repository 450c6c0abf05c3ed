"""What verifies a plan: an engine with the verifier's own options, and worlds close to the problem.

The options of a recipe's engine are the planner's business: a plan that holds with long steps or
endless forces is not one that holds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from mamo_core.build_context import BuildContext, EngineFor, PlanVerifier
from mamo_core.choices import Choice
from mamo_core.hookspecs import Options
from mamo_core.interfaces.transition_model import Replay, TransitionModel
from mamo_core.margin import possible_poses
from mamo_core.types.deviation import NEAR, Deviation, neighbours
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Plan

if TYPE_CHECKING:
    from mamo_core.verify import VerifyReport

_SEED = 1

FRICTION_GRASPS = "friction_grasps"
"""Of backends that have the option ``grasp: friction``."""


class VerifiersEngines:
    """The engine of a recipe with the verifier's own options, made when it is asked for."""

    def __init__(
        self, chosen: Choice, context: BuildContext, engines: Callable[[Choice], EngineFor]
    ) -> None:
        """``engines``: what builds a chosen engine for any problem."""
        plain = replace(chosen, options=_own(chosen.options))
        self._context, self._engine_for = context, engines(plain)
        self._step: float | None = getattr(plain.options, "time_step", None)
        self._provides = plain.component.provides
        self.trusted = chosen.options == plain.options
        """Whether the recipe's engine is the verifier's."""

    @cached_property
    def own(self) -> TransitionModel:
        """What replays the plan."""
        if self.trusted:
            backend: TransitionModel = self._context.part("backend")
            return backend
        return self._engine_for(self._context.problem)

    @cached_property
    def friction(self) -> TransitionModel | None:
        """The engine without welds; None if it cannot hold things so."""
        if FRICTION_GRASPS not in self._provides:
            return None
        return self._engine_for(self._context.problem, {"grasp": "friction"})

    @property
    def unasked(self) -> tuple[str, ...]:
        """In words, what this engine cannot be asked."""
        welds = "whether fingers and friction hold what is carried: the engine welds it"
        coarse = "whether the plan holds at finer steps: the engine has no time step as an option"
        return (
            *((welds,) if FRICTION_GRASPS not in self._provides else ()),
            *((coarse,) if self._step is None else ()),
        )

    def replays(
        self, problem: Problem | None = None, wider: Deviation = NEAR, extra: int = 0
    ) -> tuple[Replay, ...]:
        """The problem moved by a hair's breadth, and the problem at finer steps.

        ``problem``: the same one with other limits; ``extra``: so many more worlds, ``wider`` off.
        An engine that has no time step as an option cannot be asked for a finer one.
        """
        if problem is None:
            return self._replays
        found = self._around(problem, self._engine_for(problem))
        rng = np.random.default_rng(_SEED)
        joints = problem.initial.joint_positions
        starts = (SceneState(joints, possible_poses(problem, wider, rng)) for _ in range(extra))
        more = (
            Replay(f"moved farther, number {n}", found[0].model, start)
            for n, start in enumerate(starts, start=1)
        )
        return (*found, *more)

    @cached_property
    def _replays(self) -> tuple[Replay, ...]:
        return self._around(self._context.problem, self.own)

    def _around(self, problem: Problem, model: TransitionModel) -> tuple[Replay, ...]:
        near = (
            Replay(f"moved by 0.1 mm, number {n}", model, start)
            for n, start in enumerate(neighbours(problem), start=1)
        )
        step = self._step
        finer = (
            Replay(
                f"at {words} steps", self._engine_for(problem, {"time_step": part}), problem.initial
            )
            for words, part in (() if step is None else (("half", step / 2), ("quarter", step / 4)))
        )
        return (*near, *finer)


def _own(options: Options) -> Options:
    """All that have a default have it; the others can only be the recipe's."""
    fields = type(options).model_fields.items()
    needed = {name: getattr(options, name) for name, field in fields if field.is_required()}
    return type(options)(**needed)


def make_verifier(context: BuildContext, engines: VerifiersEngines) -> PlanVerifier:
    """A function that verifies plans for the problem of ``context`` with all its engines.

    The first engine that finds something wrong ends it; its name stands before what it found,
    unless it is the backend.
    """
    problem, robot = context.problem, context.robot

    def check(
        plan: Plan,
        parameters: ParameterOverrides | None = None,
        executed: Sequence[RolloutResult] | None = None,
        replays: bool = True,
        friction: bool = True,
    ) -> VerifyReport:
        from mamo_core.verify import (
            verify,
            verify_by_friction,
            verify_executed,
            verify_replays,
        )

        if executed is None or not engines.trusted:
            report = verify(problem, plan, engines.own, robot, parameters=parameters)
        else:
            report = verify_executed(problem, plan, executed, robot)
        if report.ok and replays:
            report = verify_replays(report, problem, plan, engines.replays(), robot, parameters)
        if report.ok and friction and engines.friction is not None and _holds_something(plan):
            report = verify_by_friction(report, problem, plan, engines.friction, robot)
        report = replace(report, unasked=engines.unasked)
        for name, other in context.accept_in:
            if not report.ok:
                break
            theirs = verify(problem, plan, other, robot, parameters=parameters)
            failures = tuple(f"{name}: {failure}" for failure in theirs.failures)
            outside_cpu = report.outside_cpu + theirs.outside_cpu
            report = replace(report, failures=failures, outside_cpu=outside_cpu)
        return report

    return check


def _holds_something(plan: Plan) -> bool:
    return any(segment.held is not None for motion in plan.motions for segment in motion.segments)
