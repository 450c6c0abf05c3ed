"""From rows to figures: everything a report says, as plain data."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import Any

from mamo_core.classify import CLASSES
from mamo_core.study.pairs import compare_all
from mamo_core.study.rows import Row
from mamo_core.study.split import QUICK, SLOW
from mamo_core.study.statistics import par2, quantile, success_curve, wilson

CURVE = (1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 120.0, 300.0, 600.0)
TOP_CAUSES = 8
ALL = "all"


@dataclass(frozen=True)
class Subject:
    """What a report is about. ``total``: tasks, finished or not. ``budget``: CPU s.

    ``baselines``: recipes that all are compared with.
    """

    study: str
    total: int
    budget: float
    baselines: tuple[str, ...]


def analyse(subject: Subject, rows: Sequence[Row]) -> dict[str, Any]:
    """The report as plain data; ``groups`` has a line for each planner, set and class."""
    planner_of = namer(rows)
    planners = by(rows, planner_of)
    return {
        "study": subject.study,
        "total": subject.total,
        "done": len(rows),
        "budget_s": subject.budget,
        "baselines": list(subject.baselines),
        "groups": [line for name, of in planners.items() for line in _groups(name, of, subject)],
        "curves": [_curve(name, of, subject) for name, of in planners.items()],
        "comparisons": [
            line
            for baseline in subject.baselines
            for line in compare_all(rows, baseline, planner_of)
        ],
        "shares": [_shares(name, of) for name, of in planners.items()],
        "causes": [line for name, of in planners.items() for line in _causes(name, of)],
        "failures": _failures(rows, planner_of),
        "codes": dict(sorted(Counter(row.code for row in rows).items())),
    }


def namer(rows: Iterable[Row]) -> Callable[[Row], str]:
    """What the planner of a row is called: its recipe, and the engine if there are several."""
    if len({row.engine for row in rows}) > 1:
        return lambda row: f"{row.recipe} in {row.engine}"
    return lambda row: row.recipe


def by(rows: Iterable[Row], key: Callable[[Row], str]) -> dict[str, list[Row]]:
    """Rows by a key, in the order in which the keys first come."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    return groups


def _groups(planner: str, rows: Sequence[Row], subject: Subject) -> list[dict[str, Any]]:
    sets = by(rows, lambda row: row.set_name)
    if len(sets) > 1:
        sets[ALL] = list(rows)
    lines = []
    for name, of_set in sets.items():
        levels = by(of_set, lambda row: row.level)
        for level in (ALL, *(c for c in (*CLASSES, QUICK, SLOW) if c in levels)):
            chosen = of_set if level == ALL else levels[level]
            head = {"planner": planner, "set": name, "class": level}
            lines.append({**head, **figures(chosen, subject.budget)})
    return lines


def figures(rows: Sequence[Row], budget: float) -> dict[str, Any]:
    """Success, and the seconds, actions and rollouts of the successes."""
    good = [row for row in rows if row.succeeded]
    seconds = sorted(_cpu(row) for row in good)
    simulation = sorted(row.simulation_s for row in good)
    low, high = wilson(len(good), len(rows))
    returned = sum(row.returned for row in rows)
    verified = sum(row.returned and row.verified for row in rows)
    return {
        "n": len(rows),
        "solved": returned,
        "verified": verified,
        "holds": verified / returned if returned else None,
        "succeeded": len(good),
        "success": len(good) / len(rows) if rows else None,
        "interval": [low, high],
        "par2_s": par2([_cpu(row) if row.succeeded else None for row in rows], budget),
        "cpu_s": _spread(seconds),
        "simulation_s": _spread(simulation),
        "actions": fmean(row.actions for row in good) if good else None,
        "rollouts": fmean(row.rollouts for row in good) if good else None,
    }


def _spread(ordered: Sequence[float]) -> dict[str, float | None]:
    shares = {"min": 0.0, "median": 0.5, "p90": 0.9, "max": 1.0}
    return {name: quantile(ordered, share) for name, share in shares.items()}


def _cpu(row: Row) -> float:
    assert row.cpu_s is not None, "only of rows with an answer"
    return row.cpu_s


def _curve(planner: str, rows: Sequence[Row], subject: Subject) -> dict[str, Any]:
    seconds = sorted(_cpu(row) for row in rows if row.succeeded)
    budgets = [*(b for b in CURVE if b < subject.budget), subject.budget]
    points = success_curve(seconds, len(rows), budgets)
    return {
        "planner": planner,
        "n": len(rows),
        "points": [{"budget_s": b, "success": share} for b, share in points],
        "seconds": seconds,
    }


def _shares(planner: str, rows: Sequence[Row]) -> dict[str, Any]:
    """Which part of the CPU time of all rows went where."""
    totals: Counter[str] = Counter()
    for row in rows:
        totals.update(row.parts)
    whole = sum(totals.values())
    parts = {part: s / whole for part, s in totals.most_common()} if whole else {}
    return {"planner": planner, "cpu_s": float(whole), "parts": parts}


def _causes(planner: str, rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Why problems were not solved: of each cause how often, and in how many problems."""
    times: Counter[str] = Counter()
    problems: Counter[str] = Counter()
    for row in rows:
        if not row.succeeded:
            own: Counter[str] = Counter()
            for key, count in row.causes.items():
                own[key.partition("/")[2] or key] += count  # whichever object it was
            times.update(own)
            problems.update(own.keys())
    return [
        {"planner": planner, "cause": cause, "times": count, "problems": problems[cause]}
        for cause, count in sorted(times.items(), key=lambda item: (-item[1], item[0]))[:TOP_CAUSES]
    ]


def _failures(rows: Sequence[Row], planner_of: Callable[[Row], str]) -> list[dict[str, Any]]:
    """How the rows ended that are no successes, most frequent first."""
    endings = Counter((planner_of(r), ending(r), _first_words(r)) for r in rows if not r.succeeded)
    return [
        {"planner": planner, "status": status, "reason": reason, "times": times}
        for (planner, status, reason), times in sorted(
            endings.items(), key=lambda item: (-item[1], item[0])
        )
    ]


def ending(row: Row) -> str:
    """How a row ended that is no success."""
    if not row.returned:
        return row.status
    return "not verified" if not row.verified else "over budget"


def _first_words(row: Row) -> str:
    return row.reason.partition(";")[0][:80] if row.failed or not row.returned else ""
