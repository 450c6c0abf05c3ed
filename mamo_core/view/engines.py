"""One plan in several engines from above: where each engine brings every object."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mamo_core.types.geometry import Array
from mamo_core.types.problem import Problem
from mamo_core.types.recording import Recording
from mamo_core.types.scene import Mobility
from mamo_core.view.differences import draw_differences
from mamo_core.view.topdown import EDGE, TAKEN_OUT, object_patch, surroundings

ENGINE_COLORS = ("#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#8c564b")
INITIAL = "#dddddd"
_LABEL_MOVE = 0.005


def engine_colors(recording: Recording) -> dict[str, str]:
    """A colour by engine, the first one's first."""
    engines = [execution.engine for execution in recording.executions]
    return {name: ENGINE_COLORS[i % len(ENGINE_COLORS)] for i, name in enumerate(engines)}


def draw_engines(recording: Recording, path: str | Path, title: str = "") -> None:
    """Write a PNG: initial objects grey, and in one colour per engine the ways of the objects'
    centres and their last outlines; below, how far each engine is from the first one over time."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    problem, colors = recording.problem, engine_colors(recording)
    figure = Figure(figsize=(7.0, 8.8), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    axes, below = figure.subplots(2, 1, height_ratios=(2.6, 1.0))
    surroundings(axes, problem, None)
    _initial(axes, problem)
    for execution in recording.executions:
        _engine(axes, problem, execution.poses, colors[execution.engine])
    draw_differences(below, recording, colors)
    figure.suptitle(title or problem.name, fontsize=12)
    _legend(figure, colors)
    figure.savefig(str(path), format="png")


def _initial(axes: Any, problem: Problem) -> None:
    for item, pose in zip(problem.scene.objects, problem.initial.object_poses, strict=True):
        hatch = "///" if item.mobility is Mobility.IMMOVABLE else None
        style = {"fc": INITIAL, "ec": EDGE, "lw": 0.6, "hatch": hatch, "zorder": 2}
        axes.add_patch(object_patch(item.shape, pose, **style))
        axes.text(pose[1], pose[0], item.name, ha="center", va="center", fontsize=7, zorder=6)


def _engine(axes: Any, problem: Problem, recorded: Array, color: str) -> None:
    for i, item in enumerate(problem.scene.objects):
        track = recorded[:, i, :2]
        if np.linalg.norm(track - track[0], axis=1).max() < _LABEL_MOVE:
            continue
        axes.plot(track[:, 1], track[:, 0], color=color, lw=0.9, alpha=0.8, zorder=4)
        taken = item.mobility is Mobility.TARGET
        if taken and np.linalg.norm(track[-1] - track[0]) > TAKEN_OUT:
            continue
        style = {"fill": False, "ec": color, "lw": 1.4, "zorder": 5}
        axes.add_patch(object_patch(item.shape, recorded[-1, i], **style))


def _legend(figure: Any, colors: Mapping[str, str]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = [Patch(fc=INITIAL, ec=EDGE, label="at the start (hatched: immovable)")]
    handles += [Line2D([], [], color=color, label=name) for name, color in colors.items()]
    figure.legend(handles=handles, loc="outside lower center", ncol=6, fontsize=8, frameon=False)
