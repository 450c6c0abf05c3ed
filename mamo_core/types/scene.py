"""What stands where: objects, fixtures, the workspace, and the state a planner continues from."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from mamo_core.types.geometry import Array, Shape, frozen_array, positive

MINIMUM_MASS = 0.02
"""Lighter objects are not physical in the published scenes; importers clamp to this, kg."""

ROBOT_NAME = "robot"
"""The name of the first of a scene's entities."""


class Mobility(StrEnum):
    """What may happen to an object."""

    MOVABLE = "movable"
    IMMOVABLE = "immovable"
    TARGET = "target"


@dataclass(frozen=True, eq=False)
class SceneObject:
    """A rigid object. ``mass`` in kg; ``friction`` is Coulomb's coefficient."""

    name: str
    shape: Shape
    mobility: Mobility
    mass: float
    friction: float

    def __post_init__(self) -> None:
        positive(self.mass, f"object {self.name!r}: mass")
        positive(self.friction, f"object {self.name!r}: friction")


@dataclass(frozen=True, eq=False)
class Fixture:
    """A fixed part of the world such as a shelf board; ``pose`` (7,) in the world."""

    name: str
    shape: Shape
    pose: Array
    friction: float = 1.0

    def __post_init__(self) -> None:
        positive(self.friction, f"fixture {self.name!r}: friction")
        object.__setattr__(self, "pose", frozen_array(self.pose, f"fixture {self.name!r}", (7,)))


@dataclass(frozen=True, eq=False)
class Workspace:
    """The box objects belong in: ``lower``, ``upper`` (3,) metres, world; its floor is lower z.

    ``overhang``: how far (m) a footprint may already reach past the open side at -x.
    """

    lower: Array
    upper: Array
    overhang: float = 0.05

    def __post_init__(self) -> None:
        object.__setattr__(self, "lower", frozen_array(self.lower, "workspace lower", (3,)))
        object.__setattr__(self, "upper", frozen_array(self.upper, "workspace upper", (3,)))
        if not (self.lower < self.upper).all():
            raise ValueError(
                f"workspace: lower {self.lower.tolist()} must be below upper {self.upper.tolist()}"
            )

    @property
    def floor(self) -> float:
        """Height of the supporting surface, metres."""
        return float(self.lower[2])


@dataclass(frozen=True, eq=False)
class Scene:
    """Robot, fixtures and objects; everything that never changes while planning.

    ``robot`` names a canonical arm model; ``T_world_base`` (7,) places its base.
    """

    robot: str
    T_world_base: Array
    fixtures: tuple[Fixture, ...]
    objects: tuple[SceneObject, ...]
    workspace: Workspace

    def __post_init__(self) -> None:
        object.__setattr__(self, "T_world_base", frozen_array(self.T_world_base, "base", (7,)))
        names = [o.name for o in self.objects] + [f.name for f in self.fixtures]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"scene: names used twice: {', '.join(twice)}")

    def index(self, name: str) -> int:
        """Place of the object in ``objects``.

        Raises:
            KeyError: no such object, with the names there are.
        """
        for i, item in enumerate(self.objects):
            if item.name == name:
                return i
        raise KeyError(f"no object {name!r}; objects: {', '.join(o.name for o in self.objects)}")

    @property
    def target_index(self) -> int:
        """Place of the object to retrieve, or to reach for."""
        return next(i for i, o in enumerate(self.objects) if o.mobility is Mobility.TARGET)

    @property
    def movable_indices(self) -> tuple[int, ...]:
        """Places of the movable objects."""
        return tuple(i for i, o in enumerate(self.objects) if o.mobility is Mobility.MOVABLE)

    @property
    def entities(self) -> tuple[str, ...]:
        """Names by entity number: 0 the robot, then the objects, then the fixtures."""
        return (ROBOT_NAME, *(o.name for o in self.objects), *(f.name for f in self.fixtures))


@dataclass(frozen=True, eq=False)
class SceneState:
    """Arm configuration (dof,) in radians and object poses (n, 7), in the order of the scene."""

    joint_positions: Array
    object_poses: Array

    def __post_init__(self) -> None:
        joints = frozen_array(self.joint_positions, "joint_positions", (None,))
        poses = frozen_array(self.object_poses, "object_poses", (None, 7))
        object.__setattr__(self, "joint_positions", joints)
        object.__setattr__(self, "object_poses", poses)

    def with_joints(self, joint_positions: Array) -> SceneState:
        """The same objects with the arm elsewhere."""
        return SceneState(joint_positions, self.object_poses)


def displacements(before: SceneState, after: SceneState) -> Array:
    """Distance (n,) in metres each object moved between two states."""
    return np.linalg.norm(after.object_poses[:, :3] - before.object_poses[:, :3], axis=1)
