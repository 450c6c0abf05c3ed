"""The canonical arm: one description of a robot for planning and for every engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mamo_core.types.geometry import Array, frozen_array


@dataclass(frozen=True, eq=False)
class LinkModel:
    """A rigid body of the arm. Its frame is the frame of its joint after the joint moved.

    ``parent``: number of the parent link, -1 the base. ``T_parent_joint`` (4, 4): joint frame at
    position 0 in the parent link. ``axis`` (3,): joint axis in the joint frame; ``prismatic``:
    slides along it instead of turning. ``coordinate``: index of the arm joint that moves it, or -1
    for a finger, which moves with the gripper. ``per_opening``: finger joint position is
    ``offset + gripper_angle(opening) * per_opening``. Inertia (3, 3) is about ``center_of_mass``,
    in link axes. ``hull``: convex hull in the link frame (OBJ, m). ``meshes``: exact collision
    mesh (STL, m, link frame), None if there is none. ``spheres`` (k, 4): conservative cover x, y,
    z, r of mesh and hull in the link frame.
    """

    name: str
    parent: int
    T_parent_joint: Array
    axis: Array
    prismatic: bool
    coordinate: int
    finger_gain: float
    mass: float
    center_of_mass: Array
    inertia: Array
    hull: Path | None
    mesh: Path | None
    spheres: Array


@dataclass(frozen=True, eq=False)
class GripperModel:
    """``angle_of_opening``: table (k, 2) of opening (m) -> driving joint position, increasing."""

    max_opening: float
    closed_opening: float
    angle_of_opening: Array

    def joint_position(self, opening: float) -> float:
        """Position of the driving finger joint for a gap between the fingers, m."""
        table = self.angle_of_opening
        return float(np.interp(opening, table[:, 0], table[:, 1]))


@dataclass(frozen=True, eq=False)
class BodyBox:
    """A part of the robot's own body the arm must not hit: oriented box in the base frame.

    ``first_link``: the first link number that is checked against it; earlier ones are neighbours.
    """

    name: str
    T_base_box: Array
    size: Array
    first_link: int


@dataclass(frozen=True, eq=False)
class ArmModel:
    """An arm with a gripper. Joint arrays are (dof,), rad, rad/s and N m (or m, m/s, N)."""

    name: str
    joint_names: tuple[str, ...]
    lower: Array
    upper: Array
    velocity: Array
    effort: Array
    links: tuple[LinkModel, ...]
    tool_link: int
    T_link_tool: Array
    gripper: GripperModel
    home: Array
    body: tuple[BodyBox, ...]
    urdf: Path

    @property
    def dof(self) -> int:
        """Number of arm joints."""
        return len(self.joint_names)

    def within_limits(self, configuration: Sequence[float] | Array, slack: float = 1e-9) -> bool:
        """Whether a configuration (dof,) respects the joint limits."""
        q = frozen_array(configuration, "configuration", (self.dof,))
        return bool((q >= self.lower - slack).all() and (q <= self.upper + slack).all())
