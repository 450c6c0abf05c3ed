"""The line along which the hand pushes an object."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mamo_core.types.geometry import Array, Box, Shape, yaw_of
from mamo_planners.footprints import extent_along

_DIRECTIONS = 16
_SHARES = (-0.85, -0.5, 0.0, 0.5, 0.85)


@dataclass(frozen=True, eq=False)
class PushLine:
    """Through ``origin`` (2,), world xy; the object's edge is ``extent`` (m) before it.

    ``direction`` (2,): unit. ``length``: how far the object's edge should be pushed, m.
    """

    origin: Array
    direction: Array
    extent: float
    length: float

    @property
    def contact(self) -> Array:
        """Where the line meets the object (2,), world xy."""
        return self.origin - self.extent * self.direction

    @property
    def delta(self) -> Array:
        """The push (2,), world."""
        return self.length * self.direction

    def by(self, length: float) -> PushLine:
        """The same push by another ``length``, m."""
        return replace(self, length=length)


def through_centre(shape: Shape, pose: Array, delta: Array) -> PushLine:
    """The line that moves an object by ``delta`` (2,) and does not turn it."""
    length = float(np.linalg.norm(delta))
    direction = delta / length
    return PushLine(pose[:2], direction, extent_along(shape, pose, direction), length)


def beside_centre(shape: Box, pose: Array) -> list[PushLine]:
    """Lines of no length around an upright box: along, across and askew, at shares of its width."""
    yaw, lines = yaw_of(pose), []
    for turn in np.arange(_DIRECTIONS) * (2.0 * np.pi / _DIRECTIONS):
        along, across = _unit(turn), _unit(turn + np.pi / 2.0)
        width = float(np.abs(across) @ shape.size[:2]) / 2.0
        for share in _SHARES:
            origin = share * width * across
            extent = -_entry(origin, along, shape.size[:2] / 2.0)
            lines.append(PushLine(pose[:2] + _turned(origin, yaw), _unit(yaw + turn), extent, 0.0))
    return lines


def _entry(origin: Array, along: Array, half: Array) -> float:
    """Where (m from ``origin``) a line enters the rectangle around zero with ``half`` its sides."""
    slope = np.where(np.abs(along) < 1e-9, 1e-9, along)
    return float(np.minimum((-half - origin) / slope, (half - origin) / slope).max())


def _unit(angle: float) -> Array:
    return np.array([np.cos(angle), np.sin(angle)])


def _turned(vector: Array, yaw: float) -> Array:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])
