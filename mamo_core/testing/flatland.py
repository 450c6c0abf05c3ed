"""The plane that ``QuasiStaticModel`` lives in: who overlaps whom, and who gives way."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mamo_core.problems.footprints import Footprint, disc, footprint, separation
from mamo_core.types.geometry import Array
from mamo_core.types.rollout import ROBOT, ParameterOverrides
from mamo_core.types.scene import Scene

GRAVITY = 9.81
_PASSES = 30
_TOLERANCE = 1e-5
"""Overlaps below this count as parted, m."""


class _Body(NamedTuple):
    """A footprint over a stretch of heights; ``entity`` as in observations."""

    entity: int
    outline: Footprint
    bottom: float
    top: float


class Flatland:
    """Objects that translate in the plane; ``poses`` (n, 7) are theirs, changed in place."""

    def __init__(self, scene: Scene, poses: Array, parameters: ParameterOverrides) -> None:
        self._scene = scene
        self.poses = np.array(poses)
        self.pushed: set[int] = set()
        """Places of the objects that something has pushed so far."""
        self.jammed = False
        """Whether the last step left something overlapping."""
        self._rank: dict[int, int] = {}
        self._bodies = [self._object(i) for i in range(len(scene.objects))]
        first = 1 + len(scene.objects)
        self._walls = [
            _body(first + i, footprint(f.shape, f.pose), float(f.pose[2]), f.shape.height)
            for i, f in enumerate(scene.fixtures)
        ]
        masses, frictions = parameters.masses, parameters.frictions
        for name in (*masses, *frictions):
            scene.index(name)
        self._resistances = [
            masses.get(o.name, o.mass) * frictions.get(o.name, o.friction) * GRAVITY
            for o in scene.objects
        ]

    def place(self, index: int, pose: Array) -> None:
        """Put an object somewhere."""
        self.poses[index] = pose
        self._bodies[index] = self._object(index)

    def resistance(self) -> float:
        """Friction (N) of all objects that were pushed in the last step."""
        return sum(self._resistances[i] for i in sorted(self._rank))

    def make_way(
        self, T_world_tool: Array, opening: float, radius: float, held: int
    ) -> set[tuple[int, int]]:
        """Move objects out of fingers, walls and each other; the pairs that touched.

        Who is nearer to the tool along the chain of pushes stands firm, the other one gives way.
        """
        self._rank = {}
        contacts: set[tuple[int, int]] = set()
        pushers = _fingers(T_world_tool, opening, radius)
        if held >= 0:
            self.pushed.discard(held)
            pushers.append(self._bodies[held])
        for _ in range(_PASSES):
            found = [*self._pushed_by(pushers, held), *self._among_objects(held)]
            found += self._against_walls(held)
            contacts.update(found)
            if not found:
                break
        self.jammed = bool(found)
        contacts.update(self._wall_contacts(pushers))
        return contacts

    def _object(self, index: int) -> _Body:
        shape, pose = self._scene.objects[index].shape, self.poses[index]
        return _body(1 + index, footprint(shape, pose), float(pose[2]), shape.height)

    def _pushed_by(self, pushers: list[_Body], held: int) -> list[tuple[int, int]]:
        found = []
        for i, body in enumerate(self._bodies):
            for pusher in pushers:
                if i != held and self._part(pusher, i):
                    self._rank[i] = 0
                    found.append(_pair(pusher.entity, body.entity))
        return found

    def _among_objects(self, held: int) -> list[tuple[int, int]]:
        """Only objects that were pushed can run into others."""
        found = []
        for i in sorted(self.pushed):
            for j in range(len(self._bodies)):
                if j in (i, held) or i == held:
                    continue
                firm, loose = (i, j) if self._order(i) <= self._order(j) else (j, i)
                if self._part(self._bodies[firm], loose):
                    self._rank[loose] = self._order(firm) + 1
                    found.append(_pair(1 + i, 1 + j))
        return found

    def _against_walls(self, held: int) -> list[tuple[int, int]]:
        found = []
        for i in sorted(self.pushed - {held}):
            for wall in self._walls:
                if self._part(wall, i):
                    # Nothing pushes an object through a wall: from now on others give way to it.
                    self._rank[i] = -1
                    found.append(_pair(1 + i, wall.entity))
        return found

    def _wall_contacts(self, pushers: list[_Body]) -> set[tuple[int, int]]:
        return {
            _pair(pusher.entity, wall.entity)
            for pusher in pushers
            for wall in self._walls
            if _overlap(pusher, wall) > _TOLERANCE
        }

    def _order(self, index: int) -> int:
        return self._rank.get(index, len(self._bodies))

    def _part(self, firm: _Body, index: int) -> bool:
        """Move object ``index`` out of ``firm``; whether that was needed."""
        loose = self._bodies[index]
        if _overlap(firm, loose) <= _TOLERANCE:
            return False
        apart = separation(firm.outline, loose.outline)
        self.poses[index, 0] -= apart.distance * apart.nx
        self.poses[index, 1] -= apart.distance * apart.ny
        self._bodies[index] = self._object(index)
        self.pushed.add(index)
        return True


def _body(entity: int, outline: Footprint, middle: float, height: float) -> _Body:
    return _Body(entity, outline, middle - height / 2.0, middle + height / 2.0)


def _fingers(T_world_tool: Array, opening: float, radius: float) -> list[_Body]:
    """Two short vertical cylinders left and right of the tool, as high as they are wide."""
    x, y, z = (float(v) for v in T_world_tool[:3, 3])
    ax, ay = float(T_world_tool[0, 1]), float(T_world_tool[1, 1])
    reach = opening / 2.0 + radius
    return [
        _body(ROBOT, disc(x + side * reach * ax, y + side * reach * ay, radius), z, 2.0 * radius)
        for side in (1.0, -1.0)
    ]


def _overlap(a: _Body, b: _Body) -> float:
    """Depth (m) of two bodies in each other in the plane, 0 if one passes above the other."""
    if min(a.top, b.top) - max(a.bottom, b.bottom) <= _TOLERANCE:
        return 0.0
    if math.hypot(a.outline.x - b.outline.x, a.outline.y - b.outline.y) >= (
        a.outline.radius + b.outline.radius
    ):
        return 0.0
    return max(0.0, -separation(a.outline, b.outline).distance)


def _pair(a: int, b: int) -> tuple[int, int]:
    return (a, b) if a < b else (b, a)
