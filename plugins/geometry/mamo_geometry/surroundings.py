"""What stands around the arm, as arrays: most of it never moves and is computed once."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from mamo_core.robots.model import ArmModel, LinkModel
from mamo_core.types.geometry import (
    Array,
    Box,
    IntArray,
    Shape,
    matrix_from_pose,
    rotations_from_quats,
)
from mamo_core.types.scene import Scene
from mamo_geometry.arrays import WorldArrays


class _Placed(NamedTuple):
    """Primitives where they are: the fields of ``WorldArrays`` that depend on that."""

    centre: Array
    rotation: Array
    low: Array
    high: Array


class Surroundings:
    """The fixtures and the objects of one scene, in this order."""

    def __init__(self, scene: Scene, arm: ArmModel) -> None:
        T_world_base = matrix_from_pose(scene.T_world_base)
        still = np.array([matrix_from_pose(f.pose) for f in scene.fixtures])
        still = still.reshape(-1, 4, 4)
        items = [(f.name, f.shape) for f in scene.fixtures]
        items += [(o.name, o.shape) for o in scene.objects]
        shapes = [shape for _, shape in items]
        self._still_count = len(still)
        self._names = [name for name, _ in items]
        self._half = np.array([_half_extents(shape) for shape in shapes]).reshape(-1, 3)
        self._round = np.array([int(not isinstance(s, Box)) for s in shapes], dtype=np.int64)
        self._still = _placed(still[:, :3, 3], still[:, :3, :3], self._half[: len(still)])
        self._stretch = _Stretch(arm, T_world_base)

    def world(self, object_poses: Array, ignore: Collection[str], margin: float) -> WorldArrays:
        """All but what is in ``ignore``, objects at ``object_poses`` (n, 7); ``margin`` in m."""
        moving = _placed(
            object_poses[:, :3],
            rotations_from_quats(object_poses[:, 3:]),
            self._half[self._still_count :],
        )
        both = zip(self._still, moving, strict=True)
        placed = _Placed(*(np.concatenate(parts) for parts in both))
        half, rounded = self._half, self._round
        if ignore:
            kept = self._kept(ignore)
            placed = _Placed(*(part[kept] for part in placed))
            half, rounded = half[kept], rounded[kept]
        low, high = placed.low, placed.high
        return WorldArrays(
            placed.centre,
            placed.rotation,
            half,
            rounded,
            placed.low,
            placed.high,
            low.min(axis=0) if len(low) else np.zeros(3),
            high.max(axis=0) if len(high) else np.zeros(3),
            margin,
            self._stretch.first_active(placed.low, placed.high, margin),
        )

    def _kept(self, ignore: Collection[str]) -> IntArray:
        """Places of what is not ignored."""
        names = enumerate(self._names)
        return np.array([i for i, name in names if name not in ignore], dtype=np.int64)


def _placed(centre: Array, rotation: Array, half: Array) -> _Placed:
    spread = np.einsum("pij,pj->pi", np.abs(rotation), half)
    return _Placed(centre, rotation, centre - spread, centre + spread)


class _Stretch:
    """How far each link of an arm gets when it is stretched out from the first joint."""

    def __init__(self, arm: ArmModel, T_world_base: Array) -> None:
        links = [link for link in arm.links if link.coordinate >= 0]
        # A slide moves its root, so nothing is skipped there.
        self._slides = any(link.prismatic for link in links)
        T_root = T_world_base @ links[0].T_parent_joint
        self._root = T_root[:3, 3]
        self._low, self._high = _turned_bounds(links[0], T_root)
        reaches, stretch = [], 0.0
        for link in links[1:]:
            stretch += float(np.linalg.norm(link.T_parent_joint[:3, 3]))
            own = np.linalg.norm(link.spheres[:, :3], axis=1) + link.spheres[:, 3]
            reaches.append(stretch + float(own.max(initial=0.0)))
        self._reaches = np.array(reaches)
        self._numbers = np.arange(1, len(links))

    def first_active(self, low: Array, high: Array, margin: float) -> int:
        """The first link that could touch something with bounds ``low``, ``high`` (p, 3).

        ``margin`` in m.
        """
        if self._slides or not len(self._numbers):
            return 0
        around = np.all((low - margin <= self._high) & (high + margin >= self._low), axis=1)
        if around.any():
            return 0
        gaps = np.maximum(np.maximum(low - self._root, self._root - high), 0.0)
        near = np.linalg.norm(gaps, axis=1) <= (self._reaches + margin)[:, None]
        reached = near.any(axis=1)
        return int(self._numbers[np.argmax(reached) if reached.any() else -1])


def _turned_bounds(link: LinkModel, T: Array) -> tuple[Array, Array]:
    """Axis-aligned bounds (3,), (3,) of a link that turns all around its axis at ``T`` (4, 4)."""
    axis = T[:3, :3] @ link.axis
    along = link.spheres[:, :3] @ link.axis
    away = np.linalg.norm(link.spheres[:, :3] - along[:, None] * link.axis, axis=1)
    middle = T[:3, 3] + along[:, None] * axis
    spread = away[:, None] * np.sqrt(np.maximum(1.0 - axis**2, 0.0)) + link.spheres[:, 3:]
    return (middle - spread).min(axis=0), (middle + spread).max(axis=0)


def _half_extents(shape: Shape) -> Array:
    if isinstance(shape, Box):
        return shape.size / 2.0
    return np.array([shape.radius, shape.radius, shape.height / 2.0])
