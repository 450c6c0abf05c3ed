"""Whether one push is so like another that it will end as that did."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mamo_core.types.action import RearrangementAction

_YAW, _PITCH = 0.2, 0.15
"""Hands turned by less (rad) stand alike; those that are tried differ by more, or not at all."""


def alike(action: RearrangementAction, failed: RearrangementAction, within: float) -> bool:
    """Whether the hand stands alike, and the object would end within ``within`` (m), or come by."""
    if action.object_name != failed.object_name or not _stand_alike(action.info, failed.info):
        return False
    way, other = action.path[-1] - action.path[0], failed.path[-1] - failed.path[0]
    passed = min(1.0, float(np.linalg.norm(other) / np.linalg.norm(way))) * way
    return bool(np.linalg.norm(passed - other) < within)


def _stand_alike(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether the hand is turned about the same way to the push, and as steep."""
    turn = abs(np.remainder(one["yaw"] - other["yaw"] + np.pi, 2.0 * np.pi) - np.pi)
    return bool(turn < _YAW and abs(one["pitch"] - other["pitch"]) < _PITCH)
