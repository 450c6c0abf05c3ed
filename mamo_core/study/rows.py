"""What is known of a finished task."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from datetime import UTC, datetime
from typing import Any

from mamo_core.study.jobs import Failure, Outcome
from mamo_core.study.tasks import Task

FAILED = tuple(str(failure) for failure in Failure)
"""Statuses of tasks that ended without an answer of the planner."""

SOLVED = "solved"
_JSON = ("parts", "counts", "causes")


@dataclass(frozen=True)
class Row:
    """A finished task.

    ``level``: the problem's class. ``status``: the planner's, or crashed, timeout, error.
    ``verified``: an independent replay of the plan found nothing. ``cpu_s``: reading, composing and
    planning, engine processes included; None if the task failed; ``parts``: the same by part.
    ``counts``, ``causes``: as in ``Statistics``. ``wall_s`` includes the replay. ``started`` and
    ``finished``: UTC.
    """

    key: str
    subject: str
    set_name: str
    problem_id: str
    problem: str
    recipe: str
    engine: str
    seed: int
    budget: float
    level: str
    status: str
    verified: bool
    cpu_s: float | None
    actions: int
    reason: str
    wall_s: float
    code: str
    started: str
    finished: str
    parts: Mapping[str, float] = field(default_factory=dict)
    counts: Mapping[str, int] = field(default_factory=dict)
    causes: Mapping[str, int] = field(default_factory=dict)

    @property
    def failed(self) -> bool:
        """Whether the task ended without an answer of the planner."""
        return self.status in FAILED

    @property
    def returned(self) -> bool:
        """Whether the planner returned a plan, be it good or not."""
        return self.status == SOLVED

    @property
    def succeeded(self) -> bool:
        """Whether it counts: a plan within the budget that an independent replay confirmed."""
        return self.within(self.budget)

    def within(self, budget: float) -> bool:
        """Whether it was a success after ``budget`` CPU s already."""
        return self.returned and self.verified and self.cpu_s is not None and self.cpu_s <= budget

    @property
    def simulation_s(self) -> float:
        """CPU s of the rollouts."""
        return self.parts.get("rollouts", 0.0)

    @property
    def rollouts(self) -> int:
        return self.counts.get("rollouts", 0)


COLUMNS = tuple(item.name for item in fields(Row))


def row_of(task: Task, outcome: Outcome, level: str, code: str) -> Row:
    """The row of a task, whatever became of it."""
    value: Mapping[str, Any] = outcome.value if outcome.failure is None else {}
    return Row(
        **asdict(task),
        level=level,
        status=value["status"] if value else str(outcome.failure),
        verified=bool(value.get("verified", False)),
        cpu_s=value.get("cpu_s"),
        actions=value.get("actions", 0),
        reason=value.get("reason", outcome.cause),
        wall_s=outcome.wall,
        code=code,
        started=_utc(outcome.started),
        finished=_utc(outcome.started + outcome.wall),
        parts=value.get("parts", {}),
        counts=value.get("counts", {}),
        causes=value.get("causes", {}),
    )


def _utc(seconds: float) -> str:
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="milliseconds")


def to_columns(row: Row) -> dict[str, Any]:
    """The row as values that a table can hold."""
    data = asdict(row)
    for name in _JSON:
        data[name] = json.dumps(data[name])
    return {**data, "verified": int(row.verified)}


def from_columns(data: Mapping[str, Any]) -> Row:
    """The row that ``to_columns`` was given."""
    values = {name: data[name] for name in COLUMNS}
    for name in _JSON:
        values[name] = json.loads(values[name])
    return Row(**{**values, "verified": bool(values["verified"])})
