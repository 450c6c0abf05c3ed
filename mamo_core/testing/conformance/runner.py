"""Runs checks on a backend and judges them by what the backend declares."""

from __future__ import annotations

import multiprocessing
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from typing import Any

from mamo_core.build_context import BuildContext
from mamo_core.compose import build_component
from mamo_core.hookspecs import Component
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.plugins import discover
from mamo_core.robots.model import ArmModel
from mamo_core.testing.conformance.bench import Bench
from mamo_core.testing.conformance.table import CHECKS, Check
from mamo_core.testing.gantry_arm import gantry_arm
from mamo_core.testing.transition_cases import TransitionCases, gantry_cases, standard_constraints
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import RolloutResult

_FOOT_START = 0.53
"""The foot reaches 2 cm ahead of the tool; the scripted push begins so much farther back, m."""


class Verdict(StrEnum):
    """How a check came out."""

    PASSED = "passed"
    FAILED = "failed"
    DECLARED_UNSUPPORTED = "declared_unsupported"
    KNOWN_GAP = "known_gap"
    SKIPPED_UNDECLARED = "skipped_undeclared"


@dataclass(frozen=True)
class CheckReport:
    """``measured``: a figure in words. ``message``: why it failed, or why it is known to."""

    check: Check
    verdict: Verdict
    grade: str
    measured: str = ""
    message: str = ""


def check_backend(component: Component) -> Iterator[CheckReport]:
    """All checks on a registered backend, one after another."""
    bench = bench_of(component)
    for check in CHECKS:
        yield run_check(check, bench, component)


def run_check(check: Check, bench: Bench, component: Component) -> CheckReport:
    """One check, judged: a known gap that has healed fails, as does a declared capability that
    is not there."""
    grade = component.grades.get(check.name, check.grade)
    if check.needs is not None and check.needs not in bench.capabilities:
        return CheckReport(check, Verdict.DECLARED_UNSUPPORTED, grade, message=check.needs)
    gap = component.known_gaps.get(check.name)
    try:
        measured = check.run(bench) or ""
    except NotImplementedError as error:
        return CheckReport(check, Verdict.SKIPPED_UNDECLARED, grade, message=str(error))
    except Exception as error:
        text = (
            str(error) if isinstance(error, AssertionError) else f"{type(error).__name__}: {error}"
        )
        if gap is not None:
            return CheckReport(check, Verdict.KNOWN_GAP, grade, message=f"{gap} ({text})")
        return CheckReport(check, Verdict.FAILED, grade, message=text)
    if gap is not None:
        return CheckReport(check, Verdict.FAILED, grade, measured, f"known gap has healed: {gap}")
    return CheckReport(check, Verdict.PASSED, grade, measured)


def summary(reports: list[CheckReport]) -> dict[str, int]:
    """How often each verdict was given."""
    counts = Counter(report.verdict for report in reports)
    keys = {Verdict.KNOWN_GAP: "known_gaps"}
    return {keys.get(verdict, str(verdict)): counts[verdict] for verdict in Verdict}


def bench_of(component: Component) -> Bench:
    """A registered backend on the bench; models run in this process where it has the choice."""
    here: dict[str, Any] = {"workers": 0} if "isolated" in component.provides else {}
    return Bench(
        make=partial(_make, component, here),
        make_default=partial(_make, component, {}),
        in_new_process=partial(_in_new_process, component.name, here),
        capabilities=component.provides,
        arm=gantry_arm(),
        cases=scripted_cases(),
    )


def scripted_cases() -> TransitionCases:
    """The scripted push and crash, for the gantry's foot."""
    return gantry_cases(_FOOT_START)


def _make(
    component: Component,
    options: dict[str, Any],
    problem: Problem,
    robot: ArmModel,
    constraints: tuple[InteractionConstraint, ...],
) -> TransitionModel:
    context = replace(BuildContext(problem, robot), constraints=constraints)
    made: TransitionModel = build_component(
        "backend", component, component.options(**options), context
    )
    return made


def _in_new_process(
    name: str, options: dict[str, Any], problem: Problem, motion: Motion
) -> RolloutResult:
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        return pool.submit(_rollout, name, options, problem, motion).result()


def _rollout(name: str, options: dict[str, Any], problem: Problem, motion: Motion) -> RolloutResult:
    component = discover().component("backend", name, "conformance")
    model = _make(component, options, problem, gantry_arm(), standard_constraints(problem))
    return model.rollout(problem.initial, motion)
