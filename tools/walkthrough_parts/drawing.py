"""Pictures of a walk, seen from above as those of the view are."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mamo_core.types.geometry import Array
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility, SceneState
from mamo_core.view.topdown import ARROW, COLORS, EDGE, PATH, object_patch, surroundings
from walkthrough_parts.walk import Trial

HOLDS, FAILS = "#2a7f3f", "#c0392b"
DPI = 110
HAND, AROUND = 0.08, 0.24
"""Length of a hand as it is drawn, and half of what a detail shows, m."""


def canvas(panels: int, title: str, rows: int = 1) -> tuple[Figure, list[Any]]:
    """A figure with panels side by side."""
    columns = panels // rows
    figure = Figure(figsize=(4.6 * columns, 4.1 * rows), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title, fontsize=11)
    return figure, list(figure.subplots(rows, columns, squeeze=False).flat)


def save(figure: Figure, path: Path) -> None:
    figure.savefig(str(path), format="png")


def scene(
    axes: Any,
    problem: Problem,
    state: SceneState,
    region: SweptRegion | None,
    marked: Sequence[str] = (),
) -> None:
    """All objects where they are; ``marked`` ones have a thick outline."""
    surroundings(axes, problem, region)
    for item, pose in zip(problem.scene.objects, state.object_poses, strict=True):
        width = 2.2 if item.name in marked else 0.7
        style = {"fc": COLORS[item.mobility], "ec": EDGE, "lw": width, "alpha": 0.9, "zorder": 3}
        axes.add_patch(object_patch(item.shape, pose, **style))
        words = {"ha": "center", "va": "center", "fontsize": 6, "zorder": 6, "clip_on": True}
        axes.text(pose[1], pose[0], item.name, **words)


def paths(axes: Any, problem: Problem, state: SceneState, ways: dict[str, Array]) -> None:
    """The way (k, 2) that each object should go, and its outline at the end of it."""
    for name, way in ways.items():
        number = problem.scene.index(name)
        goal = state.object_poses[number].copy()
        goal[:2] = way[-1]
        shape = problem.scene.objects[number].shape
        style = {"fill": False, "ec": PATH, "lw": 1.3, "ls": "--", "zorder": 4}
        axes.add_patch(object_patch(shape, goal, **style))
        axes.plot(way[:, 1], way[:, 0], color=PATH, lw=2.0, zorder=5)


def sweeps(axes: Any, trials: Sequence[Trial]) -> None:
    """The hand before each candidate, numbered in the order of the offer, and the tool's way."""
    for number, trial in enumerate(trials, 1):
        start, end = trial.tool[0, ::-1], trial.tool[-1, ::-1]
        style = {"arrowstyle": "-|>", "color": ARROW, "lw": 1.2, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", xy=end, xytext=start, arrowprops=style, zorder=7)
        back = start - HAND * trial.pointing[::-1]
        axes.plot([back[0], start[0]], [back[1], start[1]], color=EDGE, lw=3.0, alpha=0.5, zorder=6)
        axes.text(*(back + 0.012 * (back - start) / HAND), str(number), fontsize=7, zorder=8)


def zoom(axes: Any, centre: Array) -> None:
    """Show only what is around a place (2,), world."""
    axes.set_xlim(centre[1] + AROUND, centre[1] - AROUND)
    axes.set_ylim(centre[0] - AROUND, centre[0] + AROUND)


def outcomes(axes: Any, problem: Problem, trials: Sequence[Trial]) -> None:
    """Where each candidate brings every object that it moves: green if it holds, else red."""
    for trial in trials:
        color = HOLDS if trial.holds else FAILS
        trace = trial.result.trace
        assert trace is not None
        for name in {*trial.result.moved, trial.action.object_name}:
            number = problem.scene.index(name)
            shape = problem.scene.objects[number].shape
            style = {"fill": False, "ec": color, "lw": 1.0, "zorder": 5}
            axes.add_patch(object_patch(shape, trace.poses[-1, number], **style))
            axes.plot(trace.poses[:, number, 1], trace.poses[:, number, 0], color=color, lw=0.8)


def moved(axes: Any, problem: Problem, before: SceneState, after: SceneState) -> None:
    """Outlines of where movables stood that have moved by more than 5 mm."""
    for item, old, new in zip(
        problem.scene.objects, before.object_poses, after.object_poses, strict=True
    ):
        if item.mobility is Mobility.MOVABLE and np.linalg.norm(new[:2] - old[:2]) > 0.005:
            style = {"fill": False, "ec": ARROW, "lw": 1.0, "ls": "--", "zorder": 4}
            axes.add_patch(object_patch(item.shape, old, **style))
            axes.plot([old[1], new[1]], [old[0], new[0]], color=ARROW, lw=1.2, zorder=5)
