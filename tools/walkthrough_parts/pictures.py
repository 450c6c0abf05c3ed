"""The pictures of a walk, one for each step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mamo_core.types.geometry import Array
from mamo_core.types.scene import SceneState
from mamo_core.view.topdown import ARROW, EDGE
from walkthrough_parts import drawing
from walkthrough_parts.measures import speeds, tilts
from walkthrough_parts.walk import Trial, Walk

TILT_LIMIT, SPEED_LIMIT = 25.0, 1.0
"""The defaults of the constraints ``tilt`` and ``speed``."""


def draw_all(way: Walk, folder: Path) -> None:
    """Write every picture into an existing folder."""
    _region(way, folder / "how_1_region.png")
    _paths(way, folder / "how_2_paths.png")
    _candidates(way, folder / "how_3_candidates.png")
    _actions(way, folder / "how_4_actions.png")
    _retrieval(way, folder / "how_5_retrieval.png")
    _verification(way, folder / "how_6_verification.png")


def _region(way: Walk, path: Path) -> None:
    figure, (left, right) = drawing.canvas(2, "The problem, and what a retrieval would sweep")
    drawing.scene(left, way.problem, way.states[0], None)
    drawing.scene(right, way.problem, way.states[0], way.region, way.in_the_way(0))
    drawing.save(figure, path)


def _paths(way: Walk, path: Path) -> None:
    answers = [answer for answer in way.notes.answers if answer.offers]
    figure, panels = drawing.canvas(len(answers), "Paths out of the region, without physics")
    for number, (axes, answer) in enumerate(zip(panels, answers, strict=True), 1):
        state = answer.offers[0].state
        axes.set_title(f"call {number}", fontsize=9)
        drawing.scene(axes, way.problem, state, way.region)
        drawing.paths(axes, way.problem, state, answer.ways)
    drawing.save(figure, path)


def _candidates(way: Walk, path: Path) -> None:
    state, trials = _most_telling(way)
    name = trials[0].action.object_name
    figure, (left, right) = drawing.canvas(2, f"Pushes of {name}: offered, and simulated")
    drawing.scene(left, way.problem, state, way.region)
    drawing.sweeps(left, trials)
    drawing.scene(right, way.problem, state, way.region)
    drawing.outcomes(right, way.problem, trials)
    for axes in (left, right):
        drawing.zoom(axes, trials[0].action.path[0])
    drawing.save(figure, path)


def _most_telling(way: Walk) -> tuple[SceneState, tuple[Trial, ...]]:
    """The offer with most failures, then most candidates."""
    offers = [offer for answer in way.notes.answers for offer in answer.offers if offer.candidates]
    tried = [(offer.state, way.trials(offer)) for offer in offers]
    return max(tried, key=lambda item: (sum(not t.holds for t in item[1]), len(item[1])))


def _actions(way: Walk, path: Path) -> None:
    figure, panels = drawing.canvas(len(way.plan.actions), "What was executed")
    steps = zip(panels, way.plan.actions, way.states, way.states[1:], strict=False)
    for number, (axes, action, before, after) in enumerate(steps, 1):
        axes.set_title(f"{number}: {action.kind} {action.object_name}", fontsize=9)
        drawing.scene(axes, way.problem, after, way.region)
        drawing.moved(axes, way.problem, before, after)
    drawing.save(figure, path)


def _retrieval(way: Walk, path: Path) -> None:
    figure, (axes,) = drawing.canvas(1, "The retrieval that was found, and the target's way out")
    drawing.scene(axes, way.problem, way.states[-1], way.swept)
    target = way.problem.scene.target_index
    track = way.recording.executions[0].poses[:, target, :2]
    axes.plot(track[:, 1], track[:, 0], color=ARROW, lw=1.5, zorder=7)
    drawing.save(figure, path)


def _verification(way: Walk, path: Path) -> None:
    times = way.recording.times
    figure, (left, right) = drawing.canvas(2, "The verification: one continuous simulation")
    _curve(left, times, tilts(way.recording), TILT_LIMIT, "largest tilt, degrees")
    _curve(right, times[1:], speeds(way.recording), SPEED_LIMIT, "largest speed, m/s")
    for axes in (left, right):
        for stretch in way.recording.stretches:
            if stretch.motion % 2:
                begin, end = times[stretch.first], times[stretch.last]
                axes.axvspan(begin, end, color="#eeeeee", lw=0)
    drawing.save(figure, path)


def _curve(axes: Any, times: Array, values: Array, limit: float, label: str) -> None:
    axes.plot(times, values, color=EDGE, lw=1.0)
    axes.axhline(limit, color=drawing.FAILS, lw=1.5, ls="--")
    axes.set_xlabel("s", fontsize=8)
    axes.set_title(label, fontsize=9)
    axes.tick_params(labelsize=7)
