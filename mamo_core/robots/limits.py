"""How fast joints may move."""

from __future__ import annotations

from dataclasses import dataclass

from mamo_core.types.geometry import Array


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Of each joint (dof,): rad/s, rad/s^2, rad/s^3 (or m where a joint slides)."""

    velocity: Array
    acceleration: Array
    jerk: Array
