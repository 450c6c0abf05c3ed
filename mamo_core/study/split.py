"""Classes of problems by how long a planner took (thesis 3.5.1: easy and difficult by NAIVE)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from mamo_core.study.rows import Row

QUICK, SLOW = "quick", "slow"
"""Problems that the planner solved within the time, and all others."""


@dataclass(frozen=True)
class Split:
    """By whether ``recipe`` succeeded within so many CPU ``seconds``."""

    recipe: str
    seconds: float = 1.0


def split_by_time(rows: Iterable[Row], split: Split) -> list[Row]:
    """The rows with classes by the time of one recipe on the same problem, engine and seed.

    Rows whose problem that recipe has not been tried on yet are left out.
    """
    kept = list(rows)
    known = {
        _subject(row): QUICK
        if row.succeeded and row.cpu_s is not None and row.cpu_s <= split.seconds
        else SLOW
        for row in kept
        if row.recipe == split.recipe
    }
    return [replace(row, level=known[_subject(row)]) for row in kept if _subject(row) in known]


def _subject(row: Row) -> tuple[str, str, int]:
    return row.problem, row.engine, row.seed
