"""How far a study is."""

from __future__ import annotations

from collections import Counter
from typing import Any

from mamo_core.study.rows import Row
from mamo_core.study.store import Store


def status_of(store: Store) -> dict[str, Any]:
    """Counts as plain data; ``done`` includes what ``failed``: crashed, timeout or error."""
    tasks, rows = store.tasks(), store.rows()
    recipes = list(dict.fromkeys(task.recipe for task in tasks))
    totals = Counter(task.recipe for task in tasks)
    return {
        "study": store.about("study"),
        "store": str(store.path),
        "total": len(tasks),
        **_counts(len(tasks), rows),
        "duplicates": store.duplicates(),
        "statuses": dict(sorted(Counter(row.status for row in rows).items())),
        "by_recipe": [
            {"recipe": name, "total": totals[name], **_counts(totals[name], of)}
            for name in recipes
            for of in [[row for row in rows if row.recipe == name]]
        ],
    }


def _counts(total: int, rows: list[Row]) -> dict[str, int]:
    return {
        "done": len(rows),
        "pending": total - len(rows),
        "failed": sum(row.failed for row in rows),
        "solved": sum(row.returned for row in rows),
        "verified": sum(row.verified for row in rows),
    }
