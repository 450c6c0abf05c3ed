"""When two states count as the same (thesis 5.5.2): within 1 cm and 5 degrees."""

from __future__ import annotations

import numpy as np

from mamo_core.types.geometry import Array, BoolArray, Cylinder, z_axes
from mamo_core.types.scene import Scene

SAME_PLACE, SAME_ANGLE = 0.01, np.radians(5.0)
"""Poses within both of these (m, rad) count as the same."""


def alike(scene: Scene, one: Array, other: Array) -> BoolArray:
    """Which objects (n,) have the same pose in both (n, 7); a cylinder's yaw does not matter."""
    near = np.linalg.norm(one[:, :3] - other[:, :3], axis=1) <= SAME_PLACE
    cosines = np.clip(np.abs((one[:, 3:] * other[:, 3:]).sum(axis=1)), 0.0, 1.0)
    turned = 2.0 * np.arccos(cosines)
    leaned = np.arccos(np.clip((z_axes(one) * z_axes(other)).sum(axis=1), -1.0, 1.0))
    round_ = np.array([isinstance(item.shape, Cylinder) for item in scene.objects])
    same: BoolArray = near & (np.where(round_, leaned, turned) <= SAME_ANGLE)
    return same
