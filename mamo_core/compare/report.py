"""Comparisons as plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import degrees, isfinite
from typing import Any

from mamo_core.compare.divergence import ActionComparison
from mamo_core.compare.plans import PlanComparison, Transfer, transfer_matrix


def report_data(comparisons: Sequence[PlanComparison]) -> dict[str, Any]:
    """Transfer matrix, executions and divergences."""
    return {
        "transfer": matrix_data(transfer_matrix(comparisons)),
        "plans": [_plan_data(comparison) for comparison in comparisons],
    }


def matrix_data(matrix: Mapping[tuple[str, str], Transfer]) -> list[dict[str, Any]]:
    """One row for each pair of planning and executing engine."""
    return [
        {
            "planned_with": planned,
            "executed_in": executed,
            "plans": cell.plans,
            "valid": cell.valid,
            "failures": dict(cell.kinds.most_common()),
        }
        for (planned, executed), cell in matrix.items()
    ]


def _plan_data(comparison: PlanComparison) -> dict[str, Any]:
    return {
        "problem": comparison.problem.name,
        "planned_with": comparison.planned_with,
        "actions": [
            *(f"{a.kind} {a.object_name}" for a in comparison.plan.actions),
            comparison.problem.task.value,
        ],
        "executions": [
            {
                "engine": execution.engine,
                "valid": execution.report.ok,
                "failures": list(execution.report.failures),
                "kinds": list(execution.report.kinds),
            }
            for execution in comparison.executions
        ],
        "divergences": [_action_data(comparison, action) for action in comparison.actions],
    }


def _action_data(comparison: PlanComparison, action: ActionComparison) -> dict[str, Any]:
    first = action.first
    return {
        "action": action.action,
        "engines": list(action.engines),
        "first": None
        if first is None
        else {
            "kind": first.kind,
            "subject": first.subject,
            "time_s": first.time,
            "value": first.value,
            "alone": action.engines[int(first.value) - 1] if first.kind == "contact" else None,
        },
        "apart_mm": 1e3 * action.apart,
        "turned_deg": degrees(action.turned),
        "chaos_floor_mm": [_millimetres(comparison, e, action.action) for e in action.engines],
    }


def _millimetres(comparison: PlanComparison, engine: str, action: int) -> float | None:
    floor = comparison.floor(engine, action)
    return 1e3 * floor if isfinite(floor) else None
