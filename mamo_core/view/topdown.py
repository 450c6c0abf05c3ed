"""The scene from above, as the papers show it: the robot stands below the picture, y to the left.

Movables blue, immovables red, target yellow, the space the retrieval sweeps (NGR) grey, intended
paths pink, rearrangements as numbered arrows. Where the task is to reach, black arrows show where
the hand shall be and where it points.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array, Cylinder, Shape, footprint_corners
from mamo_core.types.problem import Problem, Task
from mamo_core.types.recording import Recording
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility, SceneObject, SceneState
from mamo_core.types.solution import Plan

COLORS = {
    Mobility.MOVABLE: "#7fb2e5",
    Mobility.IMMOVABLE: "#e06c60",
    Mobility.TARGET: "#f5d547",
}
EDGE = "#333333"
REGION = "#b8b8b8"
WALL = "#8a7660"
PATH = "#ec5fa5"
ARROW = "#7a1f5c"
GOAL = "#111111"
MARGIN = 0.10
"""Shown around the workspace, m."""

SHOWN_MOVE = 0.005
"""Objects that moved less are drawn without their old outline, m."""

LONG_NAME = 8
"""Names with more letters are broken into lines."""

HAND = 0.05
"""Length of the arrow at a pre-grasp pose, m."""

TAKEN_OUT = 0.10
"""A target that moved farther has been retrieved, m."""


def draw(
    problem: Problem,
    path: str | Path,
    *,
    plan: Plan | None = None,
    final_state: SceneState | None = None,
    region: SweptRegion | None = None,
) -> None:
    """Write a PNG of the problem, of a plan for it, and beside that of its outcome.

    ``region`` defaults to that of the plan; ``final_state`` adds the second panel.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    panels = 1 if final_state is None else 2
    figure = Figure(figsize=(6.4 * panels, 5.9), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, panels, squeeze=False)[0]
    swept = region if region is not None else (plan.region if plan is not None else None)
    actions = plan.actions if plan is not None else ()
    scene_from_above(axes[0], problem, swept)
    _actions(axes[0], actions)
    if final_state is not None:
        axes[0].set_title("before", fontsize=10)
        axes[1].set_title("after", fontsize=10)
        surroundings(axes[1], problem, swept)
        _moves(axes[1], problem, final_state)
        _objects(axes[1], problem, final_state)
    figure.suptitle(_title(problem, plan), fontsize=12)
    _legend(figure, problem, swept, actions)
    figure.savefig(str(path), format="png")


def draw_recording(recording: Recording, path: str | Path) -> None:
    """Write a PNG of the plan and of where the first engine brought everything."""
    execution = recording.executions[0]
    final = SceneState(execution.joints[-1], execution.poses[-1])
    draw(recording.problem, path, plan=recording.plan, final_state=final)


def _title(problem: Problem, plan: Plan | None) -> str:
    if plan is None:
        return problem.name
    count = len(plan.actions)
    noun = "rearrangement" if count == 1 else "rearrangements"
    return f"{problem.name}: {count} {noun}, then the {last_part(problem)}"


def last_part(problem: Problem) -> str:
    """What the motion at the end of a plan does, in a word."""
    return "reach" if problem.task is Task.REACH else "retrieval"


def _seen(points: Array) -> Array:
    """World x, y (k, 2) as picture coordinates: y across, x up."""
    return np.asarray(points, dtype=np.float64)[:, ::-1]


def scene_from_above(axes: Any, problem: Problem, region: SweptRegion | None = None) -> None:
    """Everything that is there before anything happens."""
    surroundings(axes, problem, region)
    _objects(axes, problem, problem.initial)
    _goals(axes, problem)


def surroundings(axes: Any, problem: Problem, region: SweptRegion | None) -> None:
    """Axes, fixtures, and the region that the retrieval or reach sweeps."""
    space = problem.scene.workspace
    lower, upper = space.lower, space.upper
    axes.set_aspect("equal")
    axes.set_xlim(upper[1] + MARGIN, lower[1] - MARGIN)
    axes.set_ylim(lower[0] - space.overhang - MARGIN, upper[0] + MARGIN)
    axes.set_xlabel("y (m)", fontsize=8)
    axes.set_ylabel("x (m)", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.text(
        (lower[1] + upper[1]) / 2.0,
        lower[0] - space.overhang - 0.8 * MARGIN,
        "robot side",
        ha="center",
        fontsize=8,
        color="#777777",
    )
    if region is not None:
        _region(axes, problem, region)
    _walls(axes, problem)


def _region(axes: Any, problem: Problem, region: SweptRegion) -> None:
    top = float(problem.scene.workspace.upper[2])
    swept = np.where(region.swept_under(top), 1.0, np.nan)
    edges = [
        region.origin[axis] + np.arange(region.lowest.shape[axis] + 1) * region.resolution
        for axis in (0, 1)
    ]
    from matplotlib.colors import ListedColormap

    colors = ListedColormap([REGION])
    axes.pcolormesh(edges[1], edges[0], swept, cmap=colors, zorder=0.5, rasterized=True)


def _walls(axes: Any, problem: Problem) -> None:
    """The workspace, and the fixtures that stand beside objects (not below or above them)."""
    from matplotlib.patches import Polygon

    space = problem.scene.workspace
    (x0, y0), (x1, y1) = space.lower[:2], space.upper[:2]
    outline = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    axes.add_patch(Polygon(_seen(outline), fill=False, ec=WALL, lw=0.8, ls=":", zorder=1))
    middle = (space.lower[2] + space.upper[2]) / 2.0
    for fixture in problem.scene.fixtures:
        if abs(fixture.pose[2] - middle) < fixture.shape.height / 2.0:
            axes.add_patch(object_patch(fixture.shape, fixture.pose, fc=WALL, ec="none", zorder=1))


def object_patch(shape: Shape, pose: Array, **style: Any) -> Any:
    """The outline from above as a patch for matplotlib."""
    from matplotlib.patches import Circle, Polygon

    if isinstance(shape, Cylinder):
        return Circle((pose[1], pose[0]), shape.radius, **style)
    return Polygon(_seen(footprint_corners(shape, pose)), **style)


def _objects(axes: Any, problem: Problem, state: SceneState) -> None:
    for item, pose in zip(problem.scene.objects, state.object_poses, strict=True):
        color = COLORS[item.mobility]
        axes.add_patch(
            object_patch(item.shape, pose, fc=color, ec=EDGE, lw=0.8, alpha=0.9, zorder=3)
        )
        axes.text(
            pose[1],
            pose[0],
            item.name.replace("_", "\n") if len(item.name) > LONG_NAME else item.name,
            ha="center",
            va="center",
            fontsize=7,
            zorder=6,
            clip_on=True,
        )


def _goals(axes: Any, problem: Problem) -> None:
    """Where the approach of each grasp begins, if that is what is to be reached."""
    if problem.task is not Task.REACH:
        return
    for T_world_tool in problem.pregrasps:
        tool, along = T_world_tool[:2, 3], T_world_tool[:2, 0]
        start, end = _seen(np.array([tool - HAND * along, tool]))
        style = {"arrowstyle": "-|>", "color": GOAL, "lw": 1.6, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", xy=end, xytext=start, arrowprops=style, zorder=5)


def _moves(axes: Any, problem: Problem, final: SceneState) -> None:
    """Old outlines and a line to where the objects are now."""
    for item, old, new in zip(
        problem.scene.objects, problem.initial.object_poses, final.object_poses, strict=True
    ):
        distance = float(np.linalg.norm(new[:3] - old[:3]))
        if distance < SHOWN_MOVE:
            continue
        color = COLORS[item.mobility]
        axes.add_patch(
            object_patch(item.shape, old, fill=False, ec=color, lw=1.2, ls="--", zorder=2)
        )
        if distance > TAKEN_OUT and _is_taken_out(problem, item):
            axes.text(old[1], old[0], "retrieved", ha="center", va="center", fontsize=6, zorder=2)
            continue
        axes.plot([old[1], new[1]], [old[0], new[0]], color=ARROW, lw=1.0, zorder=4)


def _is_taken_out(problem: Problem, item: SceneObject) -> bool:
    return item.mobility is Mobility.TARGET and problem.task is Task.RETRIEVE


def _actions(axes: Any, actions: Sequence[RearrangementAction]) -> None:
    for number, action in enumerate(actions, 1):
        points = _seen(action.path)
        axes.plot(points[:, 0], points[:, 1], color=PATH, lw=2.0, alpha=0.8, zorder=4)
        if np.linalg.norm(points[-1] - points[0]) > 1e-6:
            style = {"arrowstyle": "-|>", "color": ARROW, "lw": 1.4, "shrinkA": 0, "shrinkB": 0}
            axes.annotate("", xy=points[-1], xytext=points[0], arrowprops=style, zorder=5)
        _number(axes, number, points)


def _number(axes: Any, number: int, points: Array) -> None:
    """The order of the action, beside the tip of its arrow."""
    along = points[-1] - points[0]
    length = float(np.linalg.norm(along))
    tip = points[-1] + (0.02 * along / length if length > 1e-6 else np.array([0.0, 0.03]))
    axes.text(
        *tip,
        str(number),
        fontsize=7,
        color="white",
        ha="center",
        va="center",
        zorder=7,
        clip_on=True,
        bbox={"boxstyle": "circle,pad=0.25", "fc": ARROW, "ec": "none"},
    )


def _legend(
    figure: Any,
    problem: Problem,
    region: SweptRegion | None,
    actions: Sequence[RearrangementAction],
) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    present = {item.mobility for item in problem.scene.objects}
    handles: list[Any] = [
        Patch(fc=color, ec=EDGE, label=str(mobility))
        for mobility, color in COLORS.items()
        if mobility in present
    ]
    if region is not None:
        handles.append(Patch(fc=REGION, label=f"swept by the {last_part(problem)} (NGR)"))
    if problem.task is Task.REACH:
        handles.append(Line2D([], [], color=GOAL, marker=">", ms=4, label="pre-grasp pose"))
    if actions:
        handles.append(Line2D([], [], color=PATH, lw=2.0, label="intended path"))
        handles.append(
            Line2D([], [], color=ARROW, marker=">", ms=4, label="rearrangement, in order")
        )
    figure.legend(handles=handles, loc="outside lower center", ncol=6, fontsize=7, frameon=False)
