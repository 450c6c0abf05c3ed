"""Tables of a report as rows of text: one source for Markdown and HTML."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

_MOST = 20


@dataclass(frozen=True)
class Table:
    """A table and what stands above it."""

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]


def report_tables(data: Mapping[str, Any]) -> Iterator[Table]:
    """All tables of a report that have something in them."""
    tables = (
        _success(data),
        _seconds(data),
        _curves(data),
        _comparisons(data),
        _shares(data),
        _causes(data),
        _failures(data),
    )
    yield from (table for table in tables if table.rows)


def markdown(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table, padded so that it reads well as text, too."""
    table = [[cell.replace("|", "\\|") for cell in line] for line in (header, *rows)]
    widths = [max(len(line[i]) for line in table) for i in range(len(header))]
    lines = [_cells(line, widths) for line in table]
    rule = "|" + "|".join("-" * (width + 2) for width in widths) + "|"
    return "\n".join([lines[0], rule, *lines[1:]])


def _cells(line: Sequence[str], widths: Sequence[int]) -> str:
    padded = [cell.ljust(width) for cell, width in zip(line, widths, strict=True)]
    return f"| {' | '.join(padded)} |"


def notes(data: Mapping[str, Any]) -> list[str]:
    """What a reader must know to read the tables right."""
    words = [
        f"Success: solved within {data['budget_s']:g} CPU s, reading and composing included, and "
        "verified by an independent replay. Seconds, actions and rollouts are those of the "
        "successes; PAR-2 counts a failure as twice the budget; intervals are Wilson's, 95 %.",
        "Verified: of the plans that were returned; planners that plan for uncertain parameters "
        "may return plans that do not hold for the true ones.",
        "Ratio: geometric mean of CPU seconds over those of the baseline where both succeeded, "
        "with a bootstrap interval; rollouts (in all) and medians are of these, "
        "first its own; p: McNemar's exact test on success.",
    ]
    if data["done"] < data["total"]:
        words.append(f"Not finished: {data['done']} of {data['total']} tasks are done.")
    if len(data["codes"]) > 1:
        mixed = ", ".join(f"{code}: {count}" for code, count in data["codes"].items())
        words.append(f"The rows are of different code ({mixed}).")
    return words


def _success(data: Mapping[str, Any]) -> Table:
    header = ("planner", "set", "class", "n", "solved", "verified", "holds %", "success %")
    more = ("95 % interval", "PAR-2 s", "actions", "rollouts")
    rows = [
        [
            *_names(line),
            *(str(line[name]) for name in ("n", "solved", "verified")),
            percent(line["holds"]),
            percent(line["success"]),
            "-".join(percent(share) for share in line["interval"]),
            number(line["par2_s"], 2),
            number(line["actions"], 1),
            number(line["rollouts"], 1),
        ]
        for line in data["groups"]
    ]
    return Table("Success", (*header, *more), rows)


def _seconds(data: Mapping[str, Any]) -> Table:
    header = ("planner", "set", "class", "n", "min", "median", "p90", "max")
    more = ("simulation min", "median ", "p90 ", "max ")
    rows = [
        [
            *_names(line),
            str(line["succeeded"]),
            *(number(value, 2) for value in line["cpu_s"].values()),
            *(number(value, 2) for value in line["simulation_s"].values()),
        ]
        for line in data["groups"]
    ]
    return Table("CPU seconds of the successes", (*header, *more), rows)


def _names(line: Mapping[str, Any]) -> list[str]:
    return [line["planner"], line["set"], line["class"]]


def _curves(data: Mapping[str, Any]) -> Table:
    curves = data["curves"]
    budgets = [f"{point['budget_s']:g} s" for point in curves[0]["points"]] if curves else []
    rows = [
        [curve["planner"], str(curve["n"]), *(percent(p["success"]) for p in curve["points"])]
        for curve in curves
    ]
    return Table("Success % within a budget", ("planner", "n", *budgets), rows)


def _comparisons(data: Mapping[str, Any]) -> Table:
    header = ("planner", "against", "pairs", "both", "only it", "only the other", "p")
    rows = [
        [
            line["planner"],
            line["baseline"],
            *(str(line[k]) for k in ("pairs", "both", "only_planner", "only_baseline")),
            f"{line['p']:.3g}",
            " / ".join(str(n) for n in reversed(line["rollouts"])) or "-",
            " / ".join(number(s, 2) for s in reversed(line["medians_s"])) or "-",
            number(line["ratio"], 2),
            "-".join(number(v, 2) for v in line["ratio_interval"] or (None,)),
        ]
        for line in data["comparisons"]
    ]
    more = ("rollouts", "median CPU s", "CPU ratio", "95 % interval")
    return Table("Paired comparison", (*header, *more), rows)


def _shares(data: Mapping[str, Any]) -> Table:
    parts = list(dict.fromkeys(part for line in data["shares"] for part in line["parts"]))
    rows = [
        [line["planner"], number(line["cpu_s"], 1), *(percent(line["parts"].get(p)) for p in parts)]
        for line in data["shares"]
        if line["parts"]
    ]
    return Table("Shares of the CPU time of all problems, %", ("planner", "CPU s", *parts), rows)


def _causes(data: Mapping[str, Any]) -> Table:
    rows = [
        [line["planner"], line["cause"], str(line["times"]), str(line["problems"])]
        for line in data["causes"]
    ]
    return Table("Causes in unsolved problems", ("planner", "cause", "times", "problems"), rows)


def _failures(data: Mapping[str, Any]) -> Table:
    rows = [
        [line["planner"], line["status"], line["reason"], str(line["times"])]
        for line in data["failures"][:_MOST]
    ]
    return Table("How the others ended", ("planner", "status", "reason", "times"), rows)


def percent(share: float | None) -> str:
    """A share in per cent."""
    return number(None if share is None else 100.0 * share, 1)


def number(value: float | None, digits: int) -> str:
    """A number, or a dash if there is none."""
    return "-" if value is None else f"{value:.{digits}f}"
