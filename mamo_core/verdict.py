"""What verifies a plan: an engine with the verifier's own options, and worlds close to the problem.

The options of a recipe's engine are the planner's business: a plan that holds with long steps or
endless forces is not one that holds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from mamo_core.build_context import BuildContext, PlanVerifier
from mamo_core.choices import Choice, changed
from mamo_core.interfaces.transition_model import Replay, TransitionModel
from mamo_core.types.deviation import neighbours
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.solution import Plan

if TYPE_CHECKING:
    from mamo_core.verify import VerifyReport

Build = Callable[[Choice, BuildContext], Any]
"""Builds the component that was chosen."""


class VerifiersEngines:
    """The engine of a recipe with the verifier's own options, made when it is asked for."""

    def __init__(self, chosen: Choice, context: BuildContext, build: Build) -> None:
        self._chosen, self._context, self._build = chosen, context, build
        self._plain = replace(chosen, options=chosen.component.options())

    @cached_property
    def trusted(self) -> bool:
        """Whether the recipe's engine is the verifier's."""
        return self._chosen.options == self._plain.options

    @cached_property
    def own(self) -> TransitionModel:
        """What replays the plan."""
        if self.trusted:
            backend: TransitionModel = self._context.part("backend")
            return backend
        return self._built({})

    def replays(self) -> tuple[Replay, ...]:
        """The problem moved by a hair's breadth, and the problem at finer steps."""
        return self._replays

    @cached_property
    def _replays(self) -> tuple[Replay, ...]:
        problem = self._context.problem
        near = [
            Replay(f"moved by 0.1 mm, number {n}", self.own, start)
            for n, start in enumerate(neighbours(problem), start=1)
        ]
        finer = [
            Replay(f"at {words} steps", self._built({"time_step": step}), problem.initial)
            for words, step in self._finer_steps()
        ]
        return (*near, *finer)

    def _finer_steps(self) -> Iterator[tuple[str, float]]:
        """An engine without a time step of its own cannot have a finer one."""
        step = getattr(self._plain.options, "time_step", None)
        if step is not None:
            yield from (("half", step / 2.0), ("quarter", step / 4.0))

    def _built(self, changes: Mapping[str, Any]) -> TransitionModel:
        bare = BuildContext(
            problem=self._context.problem,
            robot=self._context.robot,
            constraints=self._context.constraints,
        )
        model: TransitionModel = self._build(changed(self._plain, changes), bare)
        return model


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
    ) -> VerifyReport:
        from mamo_core.verify import verify, verify_executed, verify_replays

        if executed is None or not engines.trusted:
            report = verify(problem, plan, engines.own, robot, parameters=parameters)
        else:
            report = verify_executed(problem, plan, executed, robot)
        if report.ok and replays:
            report = verify_replays(report, plan, engines.replays(), parameters)
        for name, other in context.accept_in:
            if not report.ok:
                break
            theirs = verify(problem, plan, other, robot, parameters=parameters)
            failures = tuple(f"{name}: {failure}" for failure in theirs.failures)
            outside_cpu = report.outside_cpu + theirs.outside_cpu
            report = replace(report, failures=failures, outside_cpu=outside_cpu)
        return report

    return check
