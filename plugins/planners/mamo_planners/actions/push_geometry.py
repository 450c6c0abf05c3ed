"""Where the hand may stand to push: the thesis' one pose, and the richer set."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from mamo_core.types.geometry import Array, tool_matrices, tool_matrix


@dataclass(frozen=True)
class ToolPose:
    """Relative to the push direction: ``yaw_offset`` and downward ``pitch``, rad.

    ``stand_off``: gap (m) to the object before the push; ``overreach``: how far (m) the fingertip
    goes past the push line, so that the side of the hand pushes.
    """

    yaw_offset: float
    pitch: float
    stand_off: float
    overreach: float = 0.0


_YAW_OFFSETS = (0.0, 0.35, -0.35, 0.7, -0.7, 1.1, -1.1, 1.57, -1.57, 1.9, -1.9)
_PITCHES = (0.52, 0.1, 0.9)
_STAND_OFFS = (0.03, 0.045, 0.07, 0.1)
_OVERREACHES = (0.035, 0.0)
_THESIS_PITCH = math.radians(30.0)
_THESIS_STAND_OFF, _THESIS_SPREAD = 0.05, 0.025


def rich_tool_poses() -> list[ToolPose]:
    """Eleven yaws x three pitches x four stand-offs, those across with two overreaches."""
    poses = []
    for yaw, pitch, stand_off in product(_YAW_OFFSETS, _PITCHES, _STAND_OFFS):
        side = abs(float(np.sin(yaw)))
        for overreach in _OVERREACHES if side > 0.5 else (_OVERREACHES[0] * side,):
            poses.append(ToolPose(yaw, pitch, stand_off, overreach))
    return poses


def awkwardness(pose: ToolPose) -> float:
    """Lower for pushes that more often succeed: along the hand, from close by, not too steep."""
    return (
        0.6 * abs(pose.yaw_offset)
        + 1.0 * abs(pose.pitch - _THESIS_PITCH)
        + 6.0 * pose.stand_off
        - 4.0 * pose.overreach
    )


def thesis_tool_poses(rng: np.random.Generator) -> list[ToolPose]:
    """The author's: along the push, pitched by 30 degrees, 5 cm behind with noise of 2.5 cm."""
    stand_off = max(0.0, _THESIS_STAND_OFF + _THESIS_SPREAD * rng.standard_normal())
    return [ToolPose(0.0, _THESIS_PITCH, stand_off)]


class ToolPoses:
    """Tool poses to choose from, with what does not depend on the push: low over the floor."""

    def __init__(self, poses: Sequence[ToolPose], hand: Array, floor: float, gap: float) -> None:
        """``hand`` (k, 4): its spheres in the tool frame, ``gap`` (m) over the ``floor`` (m)."""
        self.poses = tuple(poses)
        self.awkwardness = np.array([awkwardness(pose) for pose in poses])
        self.stand_offs = [pose.stand_off for pose in poses]
        self._yaws = np.array([pose.yaw_offset for pose in poses])
        self._pitches = np.array([pose.pitch for pose in poses])
        self._overreaches = np.array([pose.overreach for pose in poses])
        lowest = {pitch: _lowest(hand, pitch) for pitch in {pose.pitch for pose in poses}}
        self._heights = np.array([floor - lowest[pose.pitch] + gap for pose in poses])

    def behind(self, position: Array, direction: Array, extent: float) -> Array:
        """``T_world_tool`` (n, 4, 4) at the object's ``position`` (2,), ``extent`` (m) behind it.

        Turned from the push's ``direction`` (2,) by the yaw offsets.
        """
        yaws = float(np.arctan2(direction[1], direction[0])) + self._yaws
        T = tool_matrices(np.zeros(3), yaws, self._pitches)
        T[:, :2, 3] = position - direction * (extent + np.array(self.stand_offs))[:, None]
        ahead = np.stack([np.cos(yaws), np.sin(yaws)], axis=1)
        T[:, :2, 3] += self._overreaches[:, None] * ahead
        T[:, 2, 3] = self._heights
        return T


def _lowest(hand: Array, pitch: float) -> float:
    """Height (m) of the lowest point of the hand's spheres (k, 4) over the tool, at any yaw."""
    turned = hand[:, :3] @ tool_matrix([0.0, 0.0, 0.0], 0.0, pitch)[2, :3]
    return float((turned - hand[:, 3]).min())
