"""What stood in the way of a plan: the scene from above, who is to blame, and what failed."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any

from mamo_core.types.geometry import Array, Shape
from mamo_core.types.problem import Problem
from mamo_core.view.topdown import object_patch, scene_from_above

SUBJECT = "#b3007d"
INVOLVED = "#d9480f"
_SHOWN = 12
"""Failures listed at most."""

_COLUMNS = ((0.0, "object", 13), (0.19, "action", 10), (0.34, "times", 7), (0.43, "cause", 48))
"""Place, title and letters of the columns."""


def draw_failure(
    problem: Problem,
    path: str | Path,
    *,
    headline: str,
    subjects: Collection[str],
    involved: Collection[str],
    rows: Sequence[tuple[str, str, int, str]],
) -> None:
    """Write a PNG: ``subjects`` and others ``involved`` (names) outlined, beside what failed.

    ``rows``: object, action, how often, cause in words; the most frequent first.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.0, 6.4), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    scene, words = figure.subplots(1, 2, width_ratios=(1.0, 1.05))
    scene_from_above(scene, problem)
    for names, color in ((involved, INVOLVED), (subjects, SUBJECT)):
        _outline(scene, problem, names, color)
    _list(words, rows)
    text = "\n".join(wrap(headline, 130))
    figure.suptitle(f"{problem.name}: no plan\n{text}", fontsize=10)
    _legend(figure)
    figure.savefig(str(path), format="png")


def _outline(axes: Any, problem: Problem, names: Collection[str], color: str) -> None:
    for name, (shape, pose) in _bodies(problem).items():
        if name in names:
            style = {"fill": False, "ec": color, "lw": 3.0, "zorder": 5}
            axes.add_patch(object_patch(shape, pose, **style))


def _bodies(problem: Problem) -> dict[str, tuple[Shape, Array]]:
    """Shape and first pose of all objects and fixtures, by name."""
    scene = problem.scene
    fixtures = {item.name: (item.shape, item.pose) for item in scene.fixtures}
    poses = zip(scene.objects, problem.initial.object_poses, strict=True)
    return {**fixtures, **{item.name: (item.shape, pose) for item, pose in poses}}


def _list(axes: Any, rows: Sequence[tuple[str, str, int, str]]) -> None:
    axes.set_axis_off()
    axes.set_title("what failed, and how often", fontsize=10, loc="left")
    lines = [tuple(title for _, title, _ in _COLUMNS), *(tuple(map(str, r)) for r in rows[:_SHOWN])]
    for number, line in enumerate(lines):
        for (place, _, letters), cell in zip(_COLUMNS, line, strict=True):
            shown = "\n".join(wrap(cell, letters, max_lines=2, placeholder=" …"))
            weight = "bold" if number == 0 else "normal"
            height = 1.0 - number / (_SHOWN + 2)
            axes.text(place, height, shown, fontsize=8, va="top", weight=weight, linespacing=1.0)
    if len(rows) > _SHOWN:
        axes.text(0.0, 0.0, f"and {len(rows) - _SHOWN} more", fontsize=8, va="bottom")


def _legend(figure: Any) -> None:
    from matplotlib.patches import Patch

    handles = [
        Patch(fill=False, ec=SUBJECT, lw=3.0, label="what the sentence is about"),
        Patch(fill=False, ec=INVOLVED, lw=3.0, label="what keeps it from succeeding"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncol=2, fontsize=8, frameon=False)
