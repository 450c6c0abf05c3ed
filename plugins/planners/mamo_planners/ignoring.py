"""A collision checker for which some things are not there."""

from __future__ import annotations

from collections.abc import Collection

from mamo_core.interfaces.collision_checker import CollisionChecker, CollisionWorld, HeldObject
from mamo_core.types.geometry import Array
from mamo_core.types.region import SweptRegion


class IgnoringChecker(CollisionChecker):
    """``checker`` without the objects and fixtures ``names``."""

    def __init__(self, checker: CollisionChecker, names: Collection[str]) -> None:
        self._checker, self._names = checker, tuple(names)

    def world(
        self,
        object_poses: Array,
        *,
        opening: float,
        ignore: Collection[str] = (),
        held: HeldObject | None = None,
        margin: float = 0.0,
    ) -> CollisionWorld:
        return self._checker.world(
            object_poses,
            opening=opening,
            ignore=[*ignore, *self._names],
            held=held,
            margin=margin,
        )

    def swept_region(
        self, path: Array, *, opening: float, held: HeldObject | None = None
    ) -> SweptRegion:
        return self._checker.swept_region(path, opening=opening, held=held)
