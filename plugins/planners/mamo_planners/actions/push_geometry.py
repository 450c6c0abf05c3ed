"""Where the hand may stand to push: the thesis' one pose, and the richer set."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ToolPose:
    """Relative to the push direction: ``yaw_offset`` and downward ``pitch``, rad.

    ``stand_off``: gap (m) to the object before the push; ``overreach``: how far (m) the fingertip
    goes past the push line, so that the side of the hand pushes; ``height``: extra height, m.
    """

    yaw_offset: float
    pitch: float
    stand_off: float
    overreach: float = 0.0
    height: float = 0.0


_YAW_OFFSETS = (0.0, 0.6, -0.6, 1.1, -1.1, 1.57, -1.57)
_PITCHES = (0.52, 0.1)
_STAND_OFFS = (0.045, 0.07, 0.1)
_THESIS_PITCH = np.radians(30.0)
_THESIS_STAND_OFF, _THESIS_SPREAD = 0.05, 0.025


def rich_tool_poses() -> list[ToolPose]:
    """Seven yaws x two pitches x three stand-offs; straight and short ones first."""
    return [
        ToolPose(yaw, pitch, stand_off, overreach=0.035 * abs(np.sin(yaw)))
        for stand_off in _STAND_OFFS
        for pitch in _PITCHES
        for yaw in _YAW_OFFSETS
    ]


def thesis_tool_poses(rng: np.random.Generator) -> list[ToolPose]:
    """The author's: along the push, pitched by 30 degrees, 5 cm behind with noise of 2.5 cm."""
    stand_off = max(0.0, _THESIS_STAND_OFF + _THESIS_SPREAD * rng.standard_normal())
    return [ToolPose(0.0, _THESIS_PITCH, stand_off)]
