"""The work behind ``mamo plugins check``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mamo_core.cli.output import print_json, print_table, progress, warn_of_broken_plugins
from mamo_core.plugins import discover

if TYPE_CHECKING:
    from mamo_core.testing.conformance.runner import CheckReport

DONE, BROKEN = 0, 4


def run_plugin_check(name: str, *, as_json: bool) -> int:
    """Check a backend and report; the exit code."""
    registry = discover()
    component = registry.component("backend", name, "mamo plugins check")
    warn_of_broken_plugins(registry)
    from mamo_core.testing.conformance.runner import check_backend, summary

    reports: list[CheckReport] = []
    with progress() as tell:
        for report in check_backend(component):
            tell(f"{report.check.name}: {report.verdict}")
            reports.append(report)
    counts = summary(reports)
    if as_json:
        print_json("plugins check", {"backend": name, "summary": counts, "checks": _rows(reports)})
    else:
        columns = ("check", "promise", "verdict", "grade", "measured")
        print_table(f"backend {name}", columns, [_cells(report) for report in reports])
        print(", ".join(f"{count} {key.replace('_', ' ')}" for key, count in counts.items()))
    return BROKEN if counts["failed"] or counts["skipped_undeclared"] else DONE


def _rows(reports: list[CheckReport]) -> list[dict[str, Any]]:
    return [
        {
            "name": report.check.name,
            "promise": report.check.promise,
            "verdict": str(report.verdict),
            "grade": report.grade,
            "measured": report.measured,
            "message": report.message,
        }
        for report in reports
    ]


def _cells(report: CheckReport) -> list[str]:
    what = report.measured or report.message
    return [report.check.name, report.check.promise, str(report.verdict), report.grade, what]
