"""Where two engines part: the first time, the object and the kind, action by action."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mamo_core.recording.tracks import Tracks
from mamo_core.types.geometry import Array, BoolArray, Cylinder, IntArray, z_axes
from mamo_core.types.motion import Motion
from mamo_core.types.scene import Scene

APART, TURNED = 0.01, float(np.radians(10.0))
"""Engines have parted at an object beyond this distance (m) or angle (rad)."""


@dataclass(frozen=True)
class Divergence:
    """The first sign, within one action, that two engines do not agree.

    ``kind``: position (m), orientation (rad), or contact (1: the first engine alone has it, 2: the
    second). ``subject``: an object, or a pair that touches. ``time`` s from the action's start.
    """

    kind: str
    subject: str
    time: float
    value: float


@dataclass(frozen=True)
class ActionComparison:
    """Two engines over one action of a plan (the last is the retrieval).

    ``first``: None if they agree. ``apart`` (m) and ``turned`` (rad): the most that any object's
    poses differ during the action.
    """

    action: int
    engines: tuple[str, str]
    first: Divergence | None
    apart: float
    turned: float


def compare_actions(
    scene: Scene, motions: Sequence[Motion], tracks: Tracks, engines: tuple[str, str]
) -> list[ActionComparison]:
    """One comparison for each action that both engines began."""
    numbers = np.repeat(np.arange(len(motions)), [len(m.segments) for m in motions])
    action_of = numbers[tracks.segments]
    return [
        _compare(scene, tracks, engines, action, np.flatnonzero(action_of == action))
        for action in range(int(action_of.max()) + 1)
    ]


def separation(scene: Scene, one: Array, other: Array) -> tuple[Array, Array]:
    """Distances (t, n) m and angles (t, n) rad between two arrays of poses (t, n, 7).

    The angle of a cylinder is that between its axes: nobody sees it turn about them.
    """
    distances: Array = np.linalg.norm(one[..., :3] - other[..., :3], axis=-1)
    overlap = np.abs(np.einsum("tnk,tnk->tn", one[..., 3:], other[..., 3:]))
    angles = 2.0 * np.arccos(np.clip(overlap, 0.0, 1.0))
    for i, item in enumerate(scene.objects):
        if isinstance(item.shape, Cylinder):
            cosines = np.einsum("tk,tk->t", z_axes(one[:, i]), z_axes(other[:, i]))
            angles[:, i] = np.arccos(np.clip(cosines, -1.0, 1.0))
    return distances, angles


def _compare(
    scene: Scene, tracks: Tracks, engines: tuple[str, str], action: int, rows: IntArray
) -> ActionComparison:
    one, other = (tracks.poses[name][rows] for name in engines)
    contacts = tracks.contacts[engines[0]][rows], tracks.contacts[engines[1]][rows]
    distances, angles = separation(scene, one, other)
    times = tracks.times[rows] - tracks.times[rows[0]]
    names = [item.name for item in scene.objects]
    signs = [
        *_beyond("position", distances, APART, names, times),
        *_beyond("orientation", angles, TURNED, names, times),
        *_one_sided(scene, *contacts, times),
    ]
    first = min(signs, key=lambda sign: sign.time, default=None)
    return ActionComparison(action, engines, first, float(distances.max()), float(angles.max()))


def _beyond(
    kind: str, values: Array, limit: float, names: Sequence[str], times: Array
) -> list[Divergence]:
    """For each object beyond the limit the first time that it is."""
    return [
        Divergence(kind, name, float(times[row]), float(column[row]))
        for name, column in zip(names, values.T, strict=True)
        if (column > limit).any()
        for row in [int(np.argmax(column > limit))]
    ]


def _one_sided(scene: Scene, one: BoolArray, other: BoolArray, times: Array) -> list[Divergence]:
    """Contacts among robot and objects that only one engine has during the whole action."""
    count = 1 + len(scene.objects)
    found = []
    for side, mine, theirs in ((1, one, other), (2, other, one)):
        alone: BoolArray = np.any(mine, axis=0) & ~np.any(theirs, axis=0)
        for a, b in np.argwhere(alone[:count, :count]):
            pair = f"{scene.entities[a]} - {scene.entities[b]}"
            time = float(times[int(np.argmax(mine[:, a, b]))])
            found.append(Divergence("contact", pair, time, float(side)))
    return found
