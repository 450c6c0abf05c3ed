"""What each engine keeps of the conformance suite, as the table of docs/backends.md."""

from __future__ import annotations

from collections.abc import Sequence

from mamo_core.plugins import Registry
from mamo_core.testing.conformance.runner import CheckReport, Verdict, check_backend, summary
from mamo_core.testing.conformance.table import CHECKS


def grades_table(registry: Registry, engines: Sequence[str]) -> str:
    """A row for each check: the grade of who passes, and how each engine came out."""
    reports = {
        name: list(check_backend(registry.component("backend", name, "--backends")))
        for name in engines
    }
    head = ("check", "promise", "grade", *engines)
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    for number, check in enumerate(CHECKS):
        cells = [_cell(reports[name][number]) for name in engines]
        lines.append(f"| {' | '.join([check.name, check.promise, check.grade, *cells])} |")
    totals = [_total(summary(reports[name])) for name in engines]
    return "\n".join([*lines, f"| {' | '.join(['all', '', '', *totals])} |"])


def _cell(report: CheckReport) -> str:
    if report.verdict is not Verdict.PASSED:
        return str(report.verdict).replace("_", " ")
    own = report.grade if report.grade != report.check.grade else ""
    return "; ".join(part for part in (report.measured or "passed", own) if part)


def _total(counts: dict[str, int]) -> str:
    return ", ".join(f"{n} {key.replace('_', ' ')}" for key, n in counts.items() if n)
