"""A collision checker for the gantry: one upright box for the hand, seen from above."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionChecker, CollisionWorld, HeldObject
from mamo_core.problems.footprints import Footprint, footprint, rectangle, separation
from mamo_core.testing.fakes import FINGER
from mamo_core.testing.gantry_arm import FOOT
from mamo_core.types.geometry import Array, BoolArray
from mamo_core.types.problem import Problem

_STEP = 0.02
"""Distance of the configurations along an edge that are looked at, m and rad."""

_Standing = tuple[Footprint, float]
"""A footprint and its top, m."""


class FlatChecker(CollisionChecker):
    """Sees the fingers of ``QuasiStaticModel`` and the foot of ``gantry_arm``, with all between.

    Whatever the hand is above of it passes; nothing passes above the hand, which hangs on a stalk.
    ``held`` objects and margins are not looked at.
    """

    def __init__(self, problem: Problem) -> None:
        self._scene = problem.scene

    def world(
        self,
        object_poses: Array,
        *,
        opening: float,
        ignore: Collection[str] = (),
        held: HeldObject | None = None,
        margin: float = 0.0,
    ) -> CollisionWorld:
        things = [
            *((o.name, o.shape, p) for o, p in zip(self._scene.objects, object_poses, strict=True)),
            *((f.name, f.shape, f.pose) for f in self._scene.fixtures),
        ]
        standing = [
            (footprint(shape, pose), float(pose[2]) + shape.height / 2.0)
            for name, shape, pose in things
            if name not in ignore
        ]
        return _FlatWorld(standing, opening)


class _FlatWorld(CollisionWorld):
    def __init__(self, standing: list[_Standing], opening: float) -> None:
        self._outlines = [outline for outline, _ in standing]
        self._tops = np.array([top for _, top in standing])
        self._places = np.array([(o.x, o.y) for o in self._outlines]).reshape(-1, 2)
        self._radii = np.array([o.radius for o in self._outlines])
        self._half_width = opening / 2.0 + 2.0 * FINGER

    def free(self, configurations: Array) -> BoolArray:
        rows = np.atleast_2d(configurations)
        reach = float(np.hypot(FOOT / 2.0, self._half_width))
        away = np.linalg.norm(rows[:, None, :2] - self._places, axis=2)
        near = (away < self._radii + reach) & (rows[:, 2:3] - FINGER < self._tops)
        free = np.ones(len(rows), dtype=np.bool_)
        for row, body in np.argwhere(near).tolist():
            if free[row]:
                x, y, _, yaw = rows[row].tolist()
                hand = rectangle(x, y, yaw, FOOT / 2.0, self._half_width)
                free[row] = separation(hand, self._outlines[body]).distance > 0.0
        return free

    def edges_free(self, starts: Array, ends: Array) -> BoolArray:
        pairs = zip(np.atleast_2d(starts), np.atleast_2d(ends), strict=True)
        return np.array([bool(self.free(_along(a, b)).all()) for a, b in pairs], dtype=np.bool_)


def _along(start: Array, end: Array) -> Array:
    count = max(1, int(np.ceil(np.abs(end - start).max() / _STEP)))
    return start + np.linspace(0.0, 1.0, count + 1)[:, None] * (end - start)
