"""The numbers of a walk, in words."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mamo_core.types.geometry import Array
from mamo_core.types.recording import Recording
from walkthrough_parts.walk import Walk
from walkthrough_parts.watched import Answer, Offer

STEP_MM = 10
"""A lattice step of the abstract problem."""


def told(way: Walk) -> str:
    """A line for each step."""
    counts, recording = way.statistics.counts, way.recording
    lines = [
        f"movables: {len(way.problem.scene.movable_indices)}",
        f"regions drawn: {way.drawn}; in the one taken: {_list(way.in_the_way(0))}",
        *(
            line
            for n, answer in enumerate(way.notes.answers, 1)
            for line in _answer(way, n, answer)
        ),
        f"left in the region when a retrieval is found: {_list(way.in_the_way(-1))}",
        f"rollouts: {counts['rollouts']}; retrievals asked for among all objects: "
        f"{counts['retrievals']}",
        f"verified: {recording.times[-1]:.1f} s in one piece, largest tilt "
        f"{tilts(recording).max():.1f} degrees, largest speed {speeds(recording).max():.2f} m/s",
    ]
    return "\n".join(lines)


def tilts(recording: Recording) -> Array:
    """Largest angle (t,) of any object's z axis to the vertical, degrees."""
    x, y = recording.executions[0].poses[:, :, 4], recording.executions[0].poses[:, :, 5]
    cosines = np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0)
    return np.asarray(np.degrees(np.arccos(cosines)).max(axis=1))


def speeds(recording: Recording) -> Array:
    """Largest speed (t - 1,) of any object's centre between two rows, m/s."""
    centres = recording.executions[0].poses[:, :, :3]
    gaps = np.linalg.norm(np.diff(centres, axis=0), axis=2)
    return np.asarray((gaps / np.diff(recording.times)[:, None]).max(axis=1))


def _answer(way: Walk, number: int, answer: Answer) -> Iterator[str]:
    ways = [f"{name} by {(len(path) - 1) * STEP_MM} mm" for name, path in answer.ways.items()]
    yield f"MAPF call {number} ({answer.solution.status}): {_list(ways)}"
    for offer in answer.offers:
        yield f"    push {offer.request.object_name}: {_offer(way, offer)}"


def _offer(way: Walk, offer: Offer) -> str:
    if not offer.candidates:
        return f"no candidate ({_list([f'{c} {n}' for c, n in sorted(offer.causes.items())])})"
    trials = way.trials(offer)
    faults = [f"{n} {trial.fault}" for n, trial in enumerate(trials, 1) if not trial.holds]
    words = f"{len(trials)} offered, {offer.asked} asked for"
    return f"{words}; would fail: {_list(faults)}"


def _list(names: list[str]) -> str:
    return ", ".join(names) or "none"
