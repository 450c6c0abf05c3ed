"""The canonical arm: one description of a robot for planning and for every engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mamo_core.robots.distance_field import DistanceField
from mamo_core.robots.limits import JointLimits
from mamo_core.robots.pair_table import PairTable
from mamo_core.types.geometry import Array, frozen_array


@dataclass(frozen=True, eq=False)
class LinkModel:
    """A rigid body of the arm; its frame is its joint's frame after the joint moved.

    ``parent``: number of the parent link, -1 for the base. ``T_parent_joint`` (4, 4): joint frame
    at position 0 in the parent link. ``axis`` (3,): joint axis in the joint frame; a ``prismatic``
    joint slides along it. ``coordinate``: the arm joint that moves it, or -1 for a finger, whose
    joint stands at the gripper's drive position. ``inertia`` (3, 3) is about ``center_of_mass``
    (3,), in link axes, kg m^2. ``hulls`` (OBJ) and ``meshes`` (STL): convex pieces the engines
    use and the exact surfaces, both in the link frame, metres. ``spheres`` (k, 4): x, y, z, r of a
    cover of the hulls, and so of the meshes.
    """

    name: str
    parent: int
    T_parent_joint: Array
    axis: Array
    prismatic: bool
    coordinate: int
    mass: float
    center_of_mass: Array
    inertia: Array
    hulls: tuple[Path, ...]
    meshes: tuple[Path, ...]
    spheres: Array


@dataclass(frozen=True, eq=False)
class GripperModel:
    """``drive_of_opening`` (k, 2): opening (m) and the finger joints' position, both increasing.

    ``depth``: how far (m) the space between the fingers reaches back from the tool frame.
    ``speed``: fastest change of the opening, m/s. ``force``: the most each finger presses with, N.
    """

    drive_of_opening: Array
    depth: float
    speed: float
    force: float

    @property
    def closed(self) -> float:
        """Smallest opening, m."""
        return float(self.drive_of_opening[0, 0])

    @property
    def max_opening(self) -> float:
        """Largest opening, m."""
        return float(self.drive_of_opening[-1, 0])

    def drive(self, opening: float) -> float:
        """Position of the finger joints for a gap between the fingers, m."""
        return float(self.drives(np.array([opening]))[0])

    def drives(self, openings: Array) -> Array:
        """Positions (k,) of the finger joints for gaps (k,) between the fingers, m."""
        table = self.drive_of_opening
        return np.interp(openings, table[:, 0], table[:, 1])


@dataclass(frozen=True, eq=False)
class BodyPart:
    """A part of the robot that never moves: torso, head, another arm, what carries the arm.

    ``hulls`` (OBJ): convex pieces that the engines use; ``meshes`` (STL): the exact surfaces; both
    in the base frame, metres.
    """

    name: str
    hulls: tuple[Path, ...]
    meshes: tuple[Path, ...]


@dataclass(frozen=True, eq=False)
class ArmModel:
    """An arm with a gripper, and the rest of the robot that carries it.

    Joint arrays are (dof,): rad, rad/s, rad/s^2, rad/s^3 and N m (or m and N where a joint slides).

    Parts of the robot have numbers: ``links`` first, then ``body``. ``self_pairs``: pairs that can
    touch and must not, each a link and a link before it, or a link and a body part.
    ``hull_pairs``: those of them whose hulls stand for the meshes, which engines look at.
    ``fields``: distances to the surfaces, for the planners' check of the same pairs, but for those
    of two joints that have ``tables``.
    """

    name: str
    joint_names: tuple[str, ...]
    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    jerk: Array
    effort: Array
    links: tuple[LinkModel, ...]
    tool_link: int
    T_link_tool: Array
    gripper: GripperModel
    home: Array
    body: tuple[BodyPart, ...]
    urdf: Path
    self_pairs: tuple[tuple[int, int], ...] = ()
    hull_pairs: tuple[tuple[int, int], ...] = ()
    fields: tuple[DistanceField, ...] = ()
    tables: tuple[PairTable, ...] = ()

    @property
    def dof(self) -> int:
        """Number of arm joints."""
        return len(self.joint_names)

    @property
    def limits(self) -> JointLimits:
        """How fast the joints may move."""
        return JointLimits(self.velocity, self.acceleration, self.jerk)

    @property
    def parts(self) -> tuple[LinkModel | BodyPart, ...]:
        """By number: the links, then the body."""
        return (*self.links, *self.body)

    @property
    def part_names(self) -> tuple[str, ...]:
        """Names by number of a part."""
        return tuple(part.name for part in self.parts)

    @property
    def around_home(self) -> tuple[Array, Array]:
        """Lowest and highest positions (dof,) to look at: half a turn around home at most.

        Beyond a full turn nothing new is found.
        """
        return np.maximum(self.lower, self.home - np.pi), np.minimum(self.upper, self.home + np.pi)

    def within_limits(self, configuration: Sequence[float] | Array, slack: float = 1e-9) -> bool:
        """Whether a configuration (dof,) respects the joint limits."""
        q = frozen_array(configuration, "configuration", (self.dof,))
        return bool((q >= self.lower - slack).all() and (q <= self.upper + slack).all())
