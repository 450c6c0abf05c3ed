"""Markdown tables of a success benchmark."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from statistics import fmean
from typing import Any

Row = dict[str, Any]
CLASSES = ("none", "easy", "medium", "hard", "unreachable", "unknown")
HEADER = (
    "set",
    "class",
    "n",
    "solved",
    "verified",
    "success %",
    "95 % interval",
    "median s",
    "p90 s",
    "max s",
    "actions",
    "rollouts",
)


def report(rows: Sequence[Row], budget: float) -> str:
    """Everything that is printed in the end."""
    return "\n\n".join([success_table(rows, budget), share_table(rows), _notes(rows, budget)])


def success_table(rows: Sequence[Row], budget: float) -> str:
    """Success and CPU seconds by set and class; "all" stands for every set or class."""
    sets = list(dict.fromkeys(row["set"] for row in rows))
    groups = [(name, [row for row in rows if row["set"] == name]) for name in sets]
    if len(sets) > 1:
        groups.append(("all", list(rows)))
    lines = []
    for name, group in groups:
        lines.append(_line(name, "all", group, budget))
        for level in CLASSES:
            chosen = [row for row in group if row["difficulty"] == level]
            if chosen:
                lines.append(_line(name, level, chosen, budget))
    return markdown(HEADER, lines)


def _line(name: str, level: str, rows: Sequence[Row], budget: float) -> list[str]:
    good = [row for row in rows if succeeded(row, budget)]
    low, high = wilson(len(good), len(rows))
    seconds = sorted(row["cpu_s"] for row in good)
    return [
        name,
        level,
        str(len(rows)),
        str(sum(row["status"] == "solved" for row in rows)),
        str(sum(row["verified"] for row in rows)),
        f"{100 * len(good) / len(rows):.1f}",
        f"{100 * low:.1f}-{100 * high:.1f}",
        *(_number(quantile(seconds, share), 2) for share in (0.5, 0.9, 1.0)),
        _mean(row["actions"] for row in good),
        _mean(row["rollouts"] for row in good),
    ]


def succeeded(row: Row, budget: float) -> bool:
    """Whether the row counts: a plan within the budget that an independent replay confirmed."""
    return bool(row["status"] == "solved" and row["verified"] and row["cpu_s"] <= budget)


def share_table(rows: Sequence[Row]) -> str:
    """Which part of the CPU time of all problems went where, by set."""
    sets = list(dict.fromkeys(row["set"] for row in rows))
    totals: dict[str, Counter[str]] = {name: Counter() for name in sets}
    for row in rows:
        totals[row["set"]].update(row["parts"])
    overall = sum(totals.values(), Counter[str]())
    parts = [part for part, _ in overall.most_common()]
    lines = []
    for name in sets:
        whole = sum(totals[name].values()) or 1.0
        lines.append([name, *(f"{100 * totals[name][part] / whole:.1f} %" for part in parts)])
    return markdown(("share of CPU", *parts), lines)


def _notes(rows: Sequence[Row], budget: float) -> str:
    text = (
        f"Success: solved within {budget:g} CPU s, everything included, and verified by an "
        "independent replay. Seconds, actions and rollouts are those of the successes; the "
        "interval is Wilson's."
    )
    codes = Counter(row["code"] for row in rows)
    if len(codes) > 1:
        mixed = ", ".join(f"{code}: {count}" for code, count in sorted(codes.items()))
        text += f"\nThe rows are of different code ({mixed})."
    return text


def wilson(successes: int, n: int, z: float = 1.959964) -> tuple[float, float]:
    """Wilson's score interval of a share, 95 % by default."""
    if n == 0:
        return 0.0, 1.0
    share = successes / n
    middle = share + z * z / (2 * n)
    half = z * math.sqrt(share * (1 - share) / n + z * z / (4 * n * n))
    scale = 1 + z * z / n
    return max(0.0, (middle - half) / scale), min(1.0, (middle + half) / scale)


def quantile(ordered: Sequence[float], share: float) -> float | None:
    """Quantile of ascending values with linear interpolation; None of nothing."""
    if not ordered:
        return None
    place = share * (len(ordered) - 1)
    low = math.floor(place)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (place - low) * (ordered[high] - ordered[low])


def markdown(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table, padded so that it reads well as text, too."""
    table: list[Sequence[str]] = [header, *rows]
    widths = [max(len(line[i]) for line in table) for i in range(len(header))]
    lines = [_cells(line, widths) for line in table]
    rule = "|" + "|".join("-" * (width + 2) for width in widths) + "|"
    return "\n".join([lines[0], rule, *lines[1:]])


def _cells(line: Sequence[str], widths: Sequence[int]) -> str:
    padded = [cell.ljust(width) for cell, width in zip(line, widths, strict=True)]
    return f"| {' | '.join(padded)} |"


def _mean(values: Iterable[float]) -> str:
    listed = list(values)
    return _number(fmean(listed) if listed else None, 1)


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
