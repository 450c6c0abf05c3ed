"""Where a grasped object could stand: at the end of its path, or anywhere free on the shelf."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mamo_core.types.geometry import (
    Array,
    BoolArray,
    Cylinder,
    Shape,
    footprint_corners,
    matrix_from_pose,
    pose_from_matrix,
    tool_matrix,
)
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Scene
from mamo_planners.footprints import Outlines, grown

_CYLINDER_TURNS = (0.0, 0.5, -0.5, 1.0, -1.0)


def turned(pose: Array, turn: float) -> Array:
    """``pose`` (7,) turned by ``turn`` (rad) about the vertical through it."""
    T = tool_matrix([0.0, 0.0, 0.0], turn) @ matrix_from_pose(pose)
    T[:3, 3] = pose[:3]
    return pose_from_matrix(T)


def moved_to(pose: Array, spots: npt.ArrayLike) -> Array:
    """``pose`` (7,) carried to ``spots`` (n, 2) at its height: poses (n, 7)."""
    places = np.asarray(spots, dtype=np.float64).reshape(-1, 2)
    moved = np.tile(pose, (len(places), 1))
    moved[:, :2] = places
    return moved


def turns(shape: Shape) -> tuple[float, ...]:
    """Turns (rad) about its axis that leave a shape standing as it was asked to."""
    return _CYLINDER_TURNS if isinstance(shape, Cylinder) else (0.0,)


class FreeSpots:
    """Places on the shelf where one object stands clear of all others at one state."""

    def __init__(self, scene: Scene, object_poses: Array, number: int, margin: float) -> None:
        """``margin`` (m): the distance kept from other objects and from the workspace's sides."""
        self._shape, self._pose = scene.objects[number].shape, object_poses[number]
        wide = grown(self._shape, margin)
        self._outline = footprint_corners(wide, self._pose) - self._pose[:2]
        others = [i for i in range(len(scene.objects)) if i != number]
        outlines = [footprint_corners(scene.objects[i].shape, object_poses[i]) for i in others]
        self._obstacles = Outlines(outlines)
        self._centers = object_poses[others, :2]
        self._far = np.array([_reach(o, c) for o, c in zip(outlines, self._centers, strict=True)])
        self._far += _reach(self._outline, np.zeros(2))
        self._lower = scene.workspace.lower[:2] - self._outline.min(axis=0)
        self._upper = scene.workspace.upper[:2] - self._outline.max(axis=0)

    def draw(
        self,
        region: SweptRegion,
        rng: np.random.Generator,
        tries: int,
        count: int,
        *,
        around: Array | None = None,
        within: float = np.inf,
    ) -> list[Array]:
        """Up to ``count`` free places (2,) outside ``region`` out of ``tries``, nearest first.

        Nearest to ``around`` (2,), or else to where the object is, and at most ``within`` (m) away
        along both axes.
        """
        center = self._pose[:2] if around is None else around
        lower = np.maximum(self._lower, center - within)
        upper = np.minimum(self._upper, center + within)
        found: list[Array] = []
        if not (lower < upper).all():
            return found
        drawn = rng.uniform(lower, upper, (tries, 2))
        free = drawn[self._free(drawn)]
        for xy, pose in zip(free, moved_to(turned(self._pose, 0.0), free), strict=True):
            if not region.overlaps(self._shape, pose):
                found.append(xy)
            if len(found) == count:
                break
        found.sort(key=lambda xy: float(np.linalg.norm(xy - center)))
        return found

    def _free(self, spots: Array) -> BoolArray:
        """At which ``spots`` (n, 2) the object with its margin fits: bool (n,)."""
        away = ((self._centers - spots[:, None]) ** 2).sum(axis=2)
        return ~self._obstacles.overlapped(self._outline + spots[:, None], away < self._far**2)


def _reach(outline: Array, center: Array) -> float:
    """Radius (m) about ``center`` (2,) that holds an outline (k, 2)."""
    return float(np.linalg.norm(outline - center, axis=1).max())
