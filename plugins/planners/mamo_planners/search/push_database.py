"""Successful pushes, kept so that the same push need not be simulated again (thesis 5.5.2)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array, BoolArray, footprint_corners
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.scene import SceneState
from mamo_planners.footprints import overlap
from mamo_planners.search.likeness import alike

_CELL = 0.01
_CLEARANCE = 0.01
_STEPS = 8

Clear = Callable[[Motion, SceneState, Collection[str]], bool]
"""Whether the arm, on its way after the approach, keeps clear of some objects of a state."""


@dataclass(frozen=True, eq=False)
class StoredPush:
    """A push with what it did; ``relevant`` (n,): whose pose it changed."""

    action: RearrangementAction
    before: SceneState
    after: SceneState
    relevant: BoolArray


class PushDatabase:
    """All pushes that were valid, by object and MAPF path.

    A push is used again if everything it moved stands where it stood, and everything else is
    either where it was or out of the way of the arm and of what moved.
    """

    def __init__(self, problem: Problem, clear: Clear) -> None:
        self._problem, self._clear = problem, clear
        self._stored: dict[tuple[object, ...], list[StoredPush]] = defaultdict(list)

    def add(
        self, action: RearrangementAction, path: Array, before: SceneState, after: SceneState
    ) -> None:
        """Keep a valid push for the MAPF path (k, 2) it followed."""
        same = alike(self._problem.scene, before.object_poses, after.object_poses)
        stored = StoredPush(action, before, after, ~same)
        self._stored[_key(action.object_name, path)].append(stored)

    def find(self, name: str, path: Array, state: SceneState) -> StoredPush | None:
        """A push of the object along the path that does here what it did there."""
        return next((s for s in self._stored[_key(name, path)] if self._holds(s, state)), None)

    def outcome(self, stored: StoredPush, state: SceneState) -> SceneState:
        """``state`` after the push."""
        poses = np.where(stored.relevant[:, None], stored.after.object_poses, state.object_poses)
        return SceneState(stored.after.joint_positions, poses)

    def _holds(self, stored: StoredPush, state: SceneState) -> bool:
        scene = self._problem.scene
        same = alike(scene, stored.before.object_poses, state.object_poses)
        if not same[stored.relevant].all():
            return False
        elsewhere = [int(i) for i in np.flatnonzero(~same)]
        if not elsewhere:
            return True
        names = [scene.objects[i].name for i in elsewhere]
        if any(self._in_the_way(stored, state, i) for i in elsewhere):
            return False
        return self._clear(stored.action.motion, state, names)

    def _in_the_way(self, stored: StoredPush, state: SceneState, place: int) -> bool:
        """Whether what the push moved comes near an object that stands elsewhere now."""
        scene = self._problem.scene
        outline = footprint_corners(scene.objects[place].shape, state.object_poses[place])
        for i in np.flatnonzero(stored.relevant):
            shape = scene.objects[i].shape
            start, end = (s.object_poses[i] for s in (stored.before, stored.after))
            for share in np.linspace(0.0, 1.0, _STEPS):
                pose = (1.0 - share) * start + share * end
                moving = _grown(footprint_corners(shape, pose), pose[:2])
                if overlap(moving, outline):
                    return True
        return False


def _grown(corners: Array, centre: Array) -> Array:
    """The outline with every corner farther out."""
    arms = corners - centre
    lengths = np.linalg.norm(arms, axis=1, keepdims=True)
    return centre + arms * (1.0 + np.sqrt(2.0) * _CLEARANCE / lengths)


def _key(name: str, path: Array) -> tuple[object, ...]:
    cells = np.round(path / _CELL).astype(np.int64)
    return name, cells.tobytes()
