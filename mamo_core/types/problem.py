"""A planning problem: a scene, its initial state, how to grasp the target, what is forbidden."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np

from mamo_core.types.geometry import Array, frozen_array, matrix_from_pose, positive, z_axes
from mamo_core.types.scene import Mobility, Scene, SceneState


class Task(StrEnum):
    """What is to be done with the target.

    RETRIEVE: grasp it and carry it home. REACH: bring the open hand to where a grasp's approach
    begins (its pre-grasp), the goal of thesis chapter 3.
    """

    RETRIEVE = "retrieve"
    REACH = "reach"


@dataclass(frozen=True, eq=False)
class Grasp:
    """A way to hold the target.

    ``T_object_tool`` (7,): tool frame in the object's frame while held. ``approach``: straight
    distance (m) along the tool's x axis before the grasp. ``opening``: gap between the fingers, m.
    """

    T_object_tool: Array
    approach: float
    opening: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "T_object_tool", frozen_array(self.T_object_tool, "grasp", (7,)))
        positive(self.approach, "grasp approach")
        positive(self.opening, "grasp opening")

    @property
    def T_object_pregrasp(self) -> Array:
        """Tool frame (4, 4) in the object's frame where the approach begins."""
        T = matrix_from_pose(self.T_object_tool)
        T[:3, 3] -= self.approach * T[:3, 0]
        return T


@dataclass(frozen=True, eq=False)
class ConstraintSpec:
    """An interaction constraint by its registered name, with its options (SI units)."""

    name: str
    options: Mapping[str, Any] = field(default_factory=dict)


DEFAULT_CONSTRAINTS: tuple[ConstraintSpec, ...] = (
    ConstraintSpec("contact"),
    ConstraintSpec("tilt"),
    ConstraintSpec("speed"),
    ConstraintSpec("bounds"),
    ConstraintSpec("penetration"),
)
"""Nobody touches immovables, nothing tilts, rushes or falls (thesis 2.3.2), or is pressed into
anything."""


@dataclass(frozen=True, eq=False)
class Problem:
    """What to do with the target, by one of ``grasps``; ``home`` (dof,) is where retrievals end."""

    name: str
    scene: Scene
    initial: SceneState
    home: Array
    grasps: tuple[Grasp, ...]
    constraints: tuple[ConstraintSpec, ...] = DEFAULT_CONSTRAINTS
    task: Task = Task.RETRIEVE

    def __post_init__(self) -> None:
        object.__setattr__(self, "home", frozen_array(self.home, "home", (None,)))
        targets = [o.name for o in self.scene.objects if o.mobility is Mobility.TARGET]
        if len(targets) != 1:
            found = ", ".join(targets) or "none"
            raise ValueError(f"problem {self.name!r}: exactly one target expected, found {found}")
        if self.initial.object_poses.shape[0] != len(self.scene.objects):
            raise ValueError(
                f"problem {self.name!r}: {self.initial.object_poses.shape[0]} object poses for "
                f"{len(self.scene.objects)} objects"
            )
        if self.home.shape != self.initial.joint_positions.shape:
            raise ValueError(
                f"problem {self.name!r}: home has {self.home.size} joints, the initial "
                f"configuration {self.initial.joint_positions.size}"
            )

    @property
    def initial_z_axes(self) -> Array:
        """World z axes (n, 3) of the objects at the start, the reference of the tilt limit."""
        return z_axes(self.initial.object_poses)

    @property
    def pregrasps(self) -> Array:
        """``T_world_tool`` (k, 4, 4) where the approach of each grasp begins at the start."""
        T_world_target = matrix_from_pose(self.initial.object_poses[self.scene.target_index])
        tools = [T_world_target @ grasp.T_object_pregrasp for grasp in self.grasps]
        return np.array(tools).reshape(-1, 4, 4)
