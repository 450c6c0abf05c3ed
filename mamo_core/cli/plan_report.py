"""What ``mamo plan`` tells about a solution."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mamo_core.cli.output import print_json, print_table
from mamo_core.types.problem import Task
from mamo_core.types.solution import Plan, Solution, SolutionStatus

if TYPE_CHECKING:
    from mamo_core.explain import Detail, Explanation
    from mamo_core.verify import VerifyReport

DONE = 0
NO_PLAN = 3
NOT_VERIFIED = 4
WORKER_CRASHED = 6


@dataclass(frozen=True, eq=False)
class PlanReport:
    """A solution and what an independent verification said about it.

    ``details``: what failed. ``explanation``: why there is no plan, if there is none.
    ``margin``: as in plan files, for which it is measured.
    ``cpu_seconds``: of planning, and of verifying or explaining, engine processes included.
    """

    problem: str
    task: Task
    recipe: str
    seed: int
    solution: Solution
    verification: VerifyReport | None
    cpu_seconds: float
    details: tuple[Detail, ...] = ()
    explanation: Explanation | None = None
    margin: Mapping[str, float] = field(default_factory=dict)

    @property
    def status(self) -> SolutionStatus:
        """The solution's, unless its plan did not pass."""
        if self.verification is not None and not self.verification.ok:
            return SolutionStatus.VERIFICATION_FAILED
        return self.solution.status

    @property
    def verified_plan(self) -> Plan | None:
        """The plan, if it passed."""
        return self.solution.plan if self.status is SolutionStatus.SOLVED else None

    @property
    def exit_code(self) -> int:
        """0, 3, 4 or 6."""
        if self.verification is not None and self.verification.lost:
            return WORKER_CRASHED
        codes = {SolutionStatus.SOLVED: DONE, SolutionStatus.VERIFICATION_FAILED: NOT_VERIFIED}
        return codes.get(self.status, NO_PLAN)

    @property
    def failures(self) -> tuple[str, ...]:
        """What the verification complained about."""
        return self.verification.failures if self.verification is not None else ()


def print_report(
    report: PlanReport, output: Path | None, png: Path | None, *, as_json: bool
) -> None:
    """The result on stdout."""
    written = output if report.verified_plan is not None else None
    if as_json:
        print_json("plan", _data(report, written, png))
        return
    print_table(f"{report.problem}: {report.status}", ("", ""), _summary(report, written, png))
    print_table("\nCPU seconds", ("part", "s"), _seconds(report), right=1)
    if report.explanation is not None:
        print(f"\nwhy: {report.explanation.headline}")
    if report.verified_plan is None and report.details:
        columns = ("object", "action", "times", "cause", "in words", "others involved")
        print_table("\nwhat failed", columns, _failures(report.details), right=2)


def _failures(details: Iterable[Detail]) -> Iterator[tuple[str, ...]]:
    for d in details:
        others = ", ".join(f"{name} ({times})" for name, times in d.involved)
        words = d.words if d.words != d.cause else ""
        yield d.subject, d.action, str(d.times), d.cause, words, others


def _summary(report: PlanReport, output: Path | None, png: Path | None) -> Iterator[list[str]]:
    solution = report.solution
    yield ["planner", report.recipe]
    yield ["seed", str(report.seed)]
    if solution.reason:
        yield ["reason", solution.reason]
    if solution.plan is not None:
        actions = [f"{action.kind} {action.object_name}" for action in solution.plan.actions]
        yield ["actions", ", ".join([*actions, report.task.value])]
    for name, count in sorted(solution.statistics.counts.items()):
        yield [name.replace("_", " "), str(count)]
    yield ["verification", _verification(report)]
    for failure in report.failures:
        yield ["", failure]
    for name, share in report.margin.items():
        yield [f"holds {name} off", f"{100.0 * share:.0f} %"]
    if output is not None:
        yield ["plan", str(output)]
    if png is not None:
        yield ["picture", str(png)]


def _verification(report: PlanReport) -> str:
    if report.verification is None:
        return "nothing to verify"
    return "passed" if report.verification.ok else "FAILED"


def _seconds(report: PlanReport) -> Iterator[list[str]]:
    for part, seconds in report.solution.statistics.seconds.most_common():
        yield [part, f"{seconds:.2f}"]
    yield ["total", f"{report.cpu_seconds:.2f}"]


def _data(report: PlanReport, output: Path | None, png: Path | None) -> dict[str, Any]:
    solution = report.solution
    statistics = solution.statistics
    actions = solution.plan.actions if solution.plan is not None else ()
    return {
        "problem": report.problem,
        "planner": report.recipe,
        "seed": report.seed,
        "status": str(report.status),
        "verified": report.verification.ok if report.verification is not None else None,
        "failures": list(report.failures),
        "margin": dict(report.margin),
        "reason": solution.reason,
        "actions": [{"kind": a.kind, "object": a.object_name} for a in actions],
        "cpu_s": report.cpu_seconds,
        "parts": {part: float(seconds) for part, seconds in statistics.seconds.items()},
        "counts": {name: int(count) for name, count in statistics.counts.items()},
        "causes": {key: int(times) for key, times in statistics.causes.most_common()},
        "explanation": _explained(report.explanation),
        "plan_file": str(output) if output is not None else None,
        "picture": str(png) if png is not None else None,
    }


def _explained(explanation: Explanation | None) -> dict[str, Any] | None:
    if explanation is None:
        return None
    details = [{**asdict(d), "involved": dict(d.involved)} for d in explanation.details]
    return {**asdict(explanation), "details": details}
