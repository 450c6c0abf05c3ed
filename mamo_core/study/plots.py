"""Plots of a report as SVG text; the same data make the same text."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

_LEAST = 0.05


def curve_plot(data: Mapping[str, Any]) -> str:
    """Share of problems solved over CPU seconds, a step for each success."""
    figure = Figure(figsize=(8.0, 4.5), layout="constrained")
    axes = figure.subplots()
    budget = data["budget_s"]
    for curve in data["curves"]:
        seconds = curve["seconds"]
        xs = [_LEAST, *(max(s, _LEAST) for s in seconds), budget]
        shares = [100.0 * i / curve["n"] for i in range(len(seconds) + 1)]
        axes.step(xs, [*shares, shares[-1]], where="post", label=_plain(curve["planner"]))
    _label(axes, "CPU s", "success, %")
    axes.set(xscale="log", xlim=(_LEAST, max(budget, 2 * _LEAST)), ylim=(0, 102))
    axes.legend(loc="lower right")
    return _svg(figure, "curves")


def scatter_plot(comparison: Mapping[str, Any], budget: float) -> str:
    """CPU seconds of both for each problem; what failed stands on the lines at twice the budget."""
    figure = Figure(figsize=(5.0, 5.0), layout="constrained")
    axes = figure.subplots()
    failed = 2.0 * budget
    points = [[failed if s is None else max(s, _LEAST) for s in p] for p in comparison["seconds"]]
    axes.scatter([p[0] for p in points], [p[1] for p in points], s=16, alpha=0.6)
    limits = (_LEAST, 1.5 * failed)
    axes.plot(limits, limits, color="0.6", linewidth=0.8)
    for line in (axes.axhline, axes.axvline):
        line(failed, color="tab:red", linewidth=0.8, linestyle="--")
    _label(axes, f"{comparison['baseline']}, CPU s", f"{comparison['planner']}, CPU s")
    axes.set(xscale="log", yscale="log", xlim=limits, ylim=limits, aspect="equal")
    return _svg(figure, comparison["planner"])


def share_plot(data: Mapping[str, Any]) -> str:
    """Parts of the CPU time of all problems: a bar for each planner, in per cent."""
    lines = [line for line in data["shares"] if line["parts"]]
    parts = list(dict.fromkeys(part for line in lines for part in line["parts"]))
    figure = Figure(figsize=(8.0, 1.2 + 0.4 * len(lines)), layout="constrained")
    axes = figure.subplots()
    names = [_plain(f"{line['planner']} ({line['cpu_s']:.0f} s)") for line in lines]
    begins = [0.0] * len(lines)
    for number, part in enumerate(parts):
        shares = [100.0 * line["parts"].get(part, 0.0) for line in lines]
        axes.barh(names, shares, left=begins, label=_plain(part), color=f"C{number % 10}")
        begins = [begin + share for begin, share in zip(begins, shares, strict=True)]
    axes.set(xlim=(0, 100), xlabel="CPU time of all problems, %")
    axes.invert_yaxis()
    figure.legend(loc="outside right upper", fontsize=8, frameon=False)
    return _svg(figure, "shares")


def _label(axes: Axes, x: str, y: str) -> None:
    axes.set_xlabel(_plain(x))
    axes.set_ylabel(_plain(y))
    axes.grid(visible=True, alpha=0.3)


def _plain(text: str) -> str:
    """Without what matplotlib would read as mathematics."""
    return text.replace("$", r"\$")


def _svg(figure: Figure, salt: str) -> str:
    file = io.StringIO()
    with rc_context({"svg.hashsalt": f"mamo {salt}"}):  # ids differ between plots of a page
        figure.savefig(file, format="svg", metadata={"Date": None})
    text = file.getvalue()
    return text[text.index("<svg") :]
