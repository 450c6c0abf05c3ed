"""OMPL's benchmark logs, for Planner Arena and ``ompl_benchmark_statistics.py``.

A run is a row; the same run of all planners is the same problem and seed, as far as all have it.
"""

from __future__ import annotations

import platform
from collections.abc import Callable, Sequence

from mamo_core.study.analysis import by, namer
from mamo_core.study.rows import Row

STATUSES = (
    "solved",
    "no_plan_proved",
    "budget_exhausted",
    "verification_failed",
    "crashed",
    "timeout",
    "error",
)
_PROPERTIES: dict[str, Callable[[Row], float | None]] = {
    "actions INTEGER": lambda row: row.actions,
    "correct solution BOOLEAN": lambda row: row.verified,
    "rollouts INTEGER": lambda row: row.rollouts,
    "simulation time REAL": lambda row: row.simulation_s,
    "solved BOOLEAN": lambda row: row.succeeded,
    "status ENUM": lambda row: STATUSES.index(row.status),
    "time REAL": lambda row: row.cpu_s,
    "wall time REAL": lambda row: row.wall_s,
}


def ompl_log(study: str, rows: Sequence[Row]) -> str:
    """The text of a log."""
    planners = by(rows, namer(rows))
    lines = [
        f"Experiment {study}",
        f"Running on {platform.node() or 'UNKNOWN'}",
        f"Starting at {min((row.started for row in rows), default='never')}",
        "<<<|",
        *(f"run {i}: {name}" for i, name in enumerate(_runs(rows))),
        "|>>>",
        f"{min((row.seed for row in rows), default=0)} is the random seed",
        f"{max((row.budget for row in rows), default=0.0):g} seconds per run",
        "0 MB per run",
        f"{max(map(len, planners.values()), default=0)} runs per planner",
        f"{sum(row.wall_s for row in rows):.3f} seconds spent to collect the data",
        "1 enum type",
        "|".join(("status", *STATUSES)),
        f"{len(planners)} planners",
    ]
    for name, of in planners.items():
        lines += _planner(name, of)
    return "\n".join(lines) + "\n"


def _runs(rows: Sequence[Row]) -> list[str]:
    names = (f"{row.set_name}#{row.problem_id} ({row.level}), seed {row.seed}" for row in rows)
    return list(dict.fromkeys(names))


def _planner(name: str, rows: Sequence[Row]) -> list[str]:
    return [
        name.replace(" ", "_"),
        "0 common properties",
        f"{len(_PROPERTIES)} properties for each run",
        *_PROPERTIES,
        f"{len(rows)} runs",
        *("".join(f"{_value(get(row))}; " for get in _PROPERTIES.values()) for row in rows),
        ".",
    ]


def _value(value: float | None) -> str:
    return "" if value is None else f"{value:.10g}"
