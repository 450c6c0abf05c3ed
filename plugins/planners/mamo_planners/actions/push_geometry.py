"""Where the hand may stand to push: the thesis' one pose, and the richer set."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np


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
_THESIS_PITCH = np.radians(30.0)
_THESIS_STAND_OFF, _THESIS_SPREAD = 0.05, 0.025


def rich_tool_poses() -> list[ToolPose]:
    """Eleven yaws x three pitches x four stand-offs, those across with two overreaches."""
    poses = []
    for yaw, pitch, stand_off in product(_YAW_OFFSETS, _PITCHES, _STAND_OFFS):
        side = abs(np.sin(yaw))
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
