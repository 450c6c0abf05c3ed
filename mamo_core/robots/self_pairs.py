"""Which parts of a robot have to be checked against each other: measured when an arm is built.

As MoveIt's setup assistant does it (adjacent, always, never), on the exact meshes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mamo_core.robots.kinematics import link_transforms_along
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array

SAMPLES = 2_000
"""Configurations drawn over the whole ranges, each with an opening of the gripper."""

ALWAYS = 0.5
"""Meshes that overlap in a larger share of them do so by design."""

NEVER = 0.02
"""Pairs that stay farther apart than this (m) in all of them cannot touch; with two joints between
them at most, which the samples cover densely, all pairs that do not."""

HULL_ALARMS = 0.005
"""Engines are told of pairs whose hulls touch in no larger share of configurations than this while
the meshes are apart."""

_SEED = 20
_NEAREST, _APART = 100, 0.1
"""Samples whose distance is computed, and from which distance (m) on none is."""


@dataclass(frozen=True, eq=False)
class Solid:
    """A part of the robot: its meshes and convex hulls (trimesh, in its frame)."""

    name: str
    meshes: tuple[Any, ...]
    hulls: tuple[Any, ...]


@dataclass(frozen=True)
class PairFacts:
    """What was measured of a pair ``one`` > ``other`` or of a link ``one`` and a body part.

    ``touch``: share of samples in which the meshes do; ``alarms``: in which only the hulls do;
    ``apart``: smallest distance found, m. ``joints``: so many of the arm's are between them.
    ``adjacent``: one joint, or both are the hand's. ``finger``: ``one`` is a finger.
    """

    one: int
    other: int
    adjacent: bool
    touch: float
    alarms: float
    apart: float
    joints: int
    finger: bool

    @property
    def checked(self) -> bool:
        """Whether they can touch and are not meant to."""
        near = 0.0 if self.joints <= 2 else NEVER
        return not self.adjacent and self.touch <= ALWAYS and self.apart <= near

    @property
    def tabled(self) -> bool:
        """Whether two joints alone decide, of a link that is no finger: neighbours but one, so
        near each other that covers would find them touching where they do not."""
        return self.joints == 2 and not self.finger

    @property
    def for_engines(self) -> bool:
        """Whether their hulls stand for the meshes."""
        return self.checked and self.alarms <= HULL_ALARMS


def measure_pairs(
    arm: ArmModel, solids: Sequence[Solid], carriers: Iterable[str]
) -> list[PairFacts]:
    """Facts of all pairs; ``solids``: of all links, then of all body parts.

    ``carriers``: body parts that the arm is mounted on.
    """
    samples = _Samples(arm, solids)
    mounts = {k for k, solid in enumerate(solids) if solid.name in carriers}
    links = len(arm.links)
    facts = []
    for one in range(links):
        for other in [*range(one), *range(links, len(solids))]:
            if not solids[one].meshes or not solids[other].meshes:
                continue
            adjacent = _adjacent(arm, one, other, mounts)
            touch, alarms, apart = (1.0, 1.0, 0.0) if adjacent else samples.measure(one, other)
            joints = _depth(arm, one) - (_depth(arm, other) if other < links else 0)
            finger = arm.links[one].coordinate < 0
            facts.append(PairFacts(one, other, adjacent, touch, alarms, apart, joints, finger))
    return facts


def _depth(arm: ArmModel, link: int) -> int:
    """Number of the arm's joints from the base to a link."""
    if link < 0:
        return 0
    return int(arm.links[link].coordinate >= 0) + _depth(arm, arm.links[link].parent)


def _adjacent(arm: ArmModel, one: int, other: int, mounts: set[int]) -> bool:
    hand = {arm.tool_link, *(k for k, link in enumerate(arm.links) if link.coordinate < 0)}
    if {one, other} <= hand:
        return True
    parent = arm.links[one].parent
    return parent == other or (parent < 0 and other in mounts)


class _Samples:
    """Random configurations of an arm, and what its parts do there."""

    def __init__(self, arm: ArmModel, solids: Sequence[Solid]) -> None:
        self._arm = arm
        self._geometry = [Geometry(solid) for solid in solids]
        rng = np.random.default_rng(_SEED)
        # Beyond half a turn from home nothing new is found of a joint without end.
        low, high = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
        low, high = np.minimum(low, arm.upper), np.maximum(high, arm.lower)
        self._low, self._high = low, high
        self._configurations = rng.uniform(low, high, (SAMPLES, arm.dof))
        self._openings = (arm.gripper.closed, arm.gripper.max_opening)
        self._frames = self._placed(self._configurations)

    def _placed(self, configurations: Array) -> Array:
        """``T_base_link`` (links, k, 4, 4), the gripper closed and open in turns."""
        frames = [link_transforms_along(self._arm, configurations, o) for o in self._openings]
        placed = frames[0]
        placed[:, 1::2] = frames[1][:, 1::2]
        return placed

    def measure(self, one: int, other: int) -> tuple[float, float, float]:
        """Share in which meshes touch, in which only hulls do, and the smallest distance, m."""
        a, b = self._geometry[one], self._geometry[other]
        gaps = self._gaps(self._frames, one, other)
        touch, alarms = 0, 0
        for k in np.flatnonzero(gaps <= 0.0).tolist():
            T = self._relative(self._frames, one, other, k)
            if a.meshes_touch(b, T):
                touch += 1
            elif a.hulls_touch(b, T):
                alarms += 1
        apart = 0.0 if touch else self._closest(one, other, gaps)
        return touch / SAMPLES, alarms / SAMPLES, apart

    def _gaps(self, frames: Array, one: int, other: int) -> Array:
        """Distances (k,) of the balls around two parts."""
        a, b = self._geometry[one], self._geometry[other]
        centres = frames[one, :, :3, :3] @ a.centre + frames[one, :, :3, 3]
        others = np.broadcast_to(b.centre, centres.shape)
        if other < len(frames):
            others = frames[other, :, :3, :3] @ b.centre + frames[other, :, :3, 3]
        gaps: Array = np.linalg.norm(centres - others, axis=1) - a.radius - b.radius
        return gaps

    def _relative(self, frames: Array, one: int, other: int, k: int) -> Array:
        """The transform (4, 4) of part ``one`` in part ``other``."""
        T: Array = frames[one, k]
        return np.linalg.inv(frames[other, k]) @ T if other < len(frames) else T

    def _closest(self, one: int, other: int, gaps: Array) -> float:
        """The smallest distance in the samples whose balls are nearest, m."""
        best = np.inf
        for k in np.argsort(gaps, kind="stable")[:_NEAREST].tolist():
            if gaps[k] >= min(best, _APART):
                return min(best, float(gaps[k]))
            T = self._relative(self._frames, one, other, k)
            best = min(best, self._geometry[one].distance(self._geometry[other], T))
        return best


class Geometry:
    """The meshes and hulls of a part as trees, and a ball around them."""

    def __init__(self, solid: Solid) -> None:
        self._corners = [np.array(h.vertices[:1], dtype=np.float64) for h in solid.hulls]
        self._planes = [_planes(hull) for hull in solid.hulls]
        self._mesh_trees = [_tree(mesh) for mesh in solid.meshes]
        self._hull_trees = [_tree(hull) for hull in solid.hulls]
        corners = [mesh.vertices for mesh in (*solid.meshes, *solid.hulls)] or [np.zeros((1, 3))]
        points = np.vstack(corners)
        self.centre = (points.min(axis=0) + points.max(axis=0)) / 2.0
        self.radius = float(np.linalg.norm(points - self.centre, axis=1).max())

    def meshes_touch(self, other: Geometry, T: Array) -> bool:
        """Whether surfaces meet, self at ``T`` (4, 4) in the other's frame."""
        import fcl

        pairs = _placed_pairs(self._mesh_trees, other._mesh_trees, T)
        return any(fcl.collide(a, b) for a, b in pairs)

    def hulls_touch(self, other: Geometry, T: Array) -> bool:
        """The same of the hulls, which touch from within, too."""
        import fcl

        pairs = _placed_pairs(self._hull_trees, other._hull_trees, T)
        if any(fcl.collide(a, b) for a, b in pairs):
            return True
        inverse = np.asarray(np.linalg.inv(T), dtype=np.float64)
        return any(
            _within(corner, T, planes) for corner in self._corners for planes in other._planes
        ) or any(
            _within(corner, inverse, planes) for corner in other._corners for planes in self._planes
        )

    def distance(self, other: Geometry, T: Array) -> float:
        """Between the surfaces, m; 0 where they meet."""
        import fcl

        pairs = _placed_pairs(self._mesh_trees, other._mesh_trees, T)
        return max(0.0, min(float(fcl.distance(a, b)) for a, b in pairs))


def _placed_pairs(ours: list[Any], theirs: list[Any], T: Array) -> Iterator[tuple[Any, Any]]:
    import fcl

    here = fcl.Transform(np.ascontiguousarray(T[:3, :3]), np.ascontiguousarray(T[:3, 3]))
    for a in ours:
        for b in theirs:
            yield fcl.CollisionObject(a, here), fcl.CollisionObject(b, fcl.Transform())


def _planes(hull: Any) -> tuple[Array, Array]:
    """Normals (k, 3) of the faces of a convex mesh, and their distances (k,) to the origin."""
    normals = np.array(hull.face_normals)
    return normals, np.einsum("ij,ij->i", normals, hull.triangles[:, 0])


def _within(corner: Any, T: Array, planes: tuple[Array, Array]) -> bool:
    """Whether a point (1, 3), moved by ``T`` (4, 4), is in a convex solid."""
    moved = corner[0] @ T[:3, :3].T + T[:3, 3]
    return bool((planes[0] @ moved <= planes[1]).all())


def _tree(mesh: Any) -> Any:
    import fcl

    tree = fcl.BVHModel()
    tree.beginModel(len(mesh.vertices), len(mesh.faces))
    tree.addSubModel(mesh.vertices, mesh.faces)
    tree.endModel()
    return tree
