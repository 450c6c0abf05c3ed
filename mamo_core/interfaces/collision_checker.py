"""Is a configuration, or the straight joint motion between two, free of collisions?"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection
from dataclasses import dataclass

from mamo_core.errors import PluginError
from mamo_core.types.geometry import Array, BoolArray, Shape, invert
from mamo_core.types.region import SweptRegion


@dataclass(frozen=True, eq=False)
class HeldObject:
    """An object fixed to the tool at ``T_tool_object`` (4, 4).

    ``up``: unit vector (3,) in the tool frame that points up while the object stands as it was
    taken, for checkers that keep it upright; None: the tool's z axis.
    """

    name: str
    shape: Shape
    T_tool_object: Array
    up: Array | None = None

    @classmethod
    def taken(
        cls, name: str, shape: Shape, T_world_tool: Array, T_world_object: Array
    ) -> HeldObject:
        """An object that stands at ``T_world_object`` (4, 4) when the tool takes hold of it."""
        T = invert(T_world_tool) @ T_world_object
        return cls(name, shape, T, up=T[:3, 2])


class CollisionWorld(ABC):
    """The arm, fixtures and some objects at fixed poses."""

    @abstractmethod
    def free(self, configurations: Array) -> BoolArray:
        """Which configurations (k, dof) touch nothing: bool (k,)."""

    @abstractmethod
    def edges_free(self, starts: Array, ends: Array) -> BoolArray:
        """Which straight joint motions between configurations (k, dof) touch nothing: bool (k,)."""

    def hands_free(self, T_world_tools: Array) -> BoolArray:
        """Which tool poses (k, 4, 4) keep the hand clear, wherever the arm is: bool (k,).

        A quick screen before inverse kinematics. Capability ``hands_free``.
        """
        raise PluginError(f"{type(self).__name__} does not offer hands_free")


class CollisionChecker(ABC):
    """Builds worlds for one problem; "free" from a checker is never a mesh collision."""

    @abstractmethod
    def world(
        self,
        object_poses: Array,
        *,
        opening: float,
        ignore: Collection[str] = (),
        held: HeldObject | None = None,
        margin: float = 0.0,
    ) -> CollisionWorld:
        """The world with the objects at ``object_poses`` (n, 7) but for those in ``ignore``.

        ``opening``: gap between the fingers, m. ``margin``: distance to keep, m. Names in
        ``ignore`` may be objects or fixtures; the held object must be among them.
        """

    def swept_region(
        self, path: Array, *, opening: float, held: HeldObject | None = None
    ) -> SweptRegion:
        """What the arm and the held object sweep along ``path`` (k, dof), conservatively.

        Capability ``swept_region``.
        """
        raise PluginError(f"{type(self).__name__} does not offer swept_region")
