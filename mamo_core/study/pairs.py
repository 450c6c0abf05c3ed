"""Recipes side by side: on the same problems, in the same engine, with the same seeds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from statistics import median
from typing import Any

from mamo_core.study.rows import Row
from mamo_core.study.statistics import geometric_mean_ratio, mcnemar

Pair = tuple[Row, Row]


def compare_all(
    rows: Sequence[Row], baseline: str, planner_of: Callable[[Row], str]
) -> list[dict[str, Any]]:
    """Each recipe against the baseline, by engine."""
    engines = dict.fromkeys(row.engine for row in rows)
    recipes = [name for name in dict.fromkeys(row.recipe for row in rows) if name != baseline]
    found = []
    for engine in engines:
        of_engine = [row for row in rows if row.engine == engine]
        first = {_case(row): row for row in of_engine if row.recipe == baseline}
        for recipe in recipes:
            second = [row for row in of_engine if row.recipe == recipe]
            pairs = [(first[_case(row)], row) for row in second if _case(row) in first]
            if pairs:
                names = {"baseline": planner_of(pairs[0][0]), "planner": planner_of(pairs[0][1])}
                found.append({**names, **compare(pairs)})
    return found


def _case(row: Row) -> tuple[str, str, int]:
    return row.set_name, row.problem, row.seed


def compare(pairs: Sequence[Pair]) -> dict[str, Any]:
    """Success by McNemar's test, seconds by a bootstrap over problems that both solved.

    ``rollouts`` (in all) and ``medians_s`` of these are the baseline's and the planner's; empty if
    there are none.
    """
    only_first = sum(a.succeeded and not b.succeeded for a, b in pairs)
    only_second = sum(b.succeeded and not a.succeeded for a, b in pairs)
    both = [(a, b) for a, b in pairs if a.succeeded and b.succeeded]
    ratio = geometric_mean_ratio(
        [a.cpu_s for a, _ in both if a.cpu_s is not None],
        [b.cpu_s for _, b in both if b.cpu_s is not None],
    )
    return {
        "pairs": len(pairs),
        "both": len(both),
        "only_baseline": only_first,
        "only_planner": only_second,
        "p": mcnemar(only_first, only_second),
        "rollouts": [sum(row.rollouts for row in side) for side in zip(*both, strict=True)],
        "medians_s": [median(row.cpu_s or 0.0 for row in side) for side in zip(*both, strict=True)],
        "ratio": ratio[0] if ratio is not None else None,
        "ratio_interval": list(ratio[1:]) if ratio is not None else None,
        "seconds": [_seconds(pair) for pair in pairs],
    }


def _seconds(pair: Pair) -> list[float | None]:
    """CPU s of both; None where there was no success."""
    return [row.cpu_s if row.succeeded else None for row in pair]
