"""The flat arrays the compiled kernels work on, and how they are made from models and scenes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from mamo_core.robots.distance_field import DistanceField
from mamo_core.robots.kinematics import finger_transforms
from mamo_core.robots.model import ArmModel
from mamo_core.robots.pair_table import PairTable
from mamo_core.types.geometry import Array, Box, IntArray, Shape

UIntArray = npt.NDArray[np.uintp]

_CLUSTER_SIZE = 24
_HELD_CELL = 0.012


class FieldArrays(NamedTuple):
    """Distance fields of the robot (n,), and what is checked against them.

    ``checks`` (k, 4): group of spheres, the link it is in, number of the field, and the link that
    has it (dof for the base); the first ``held`` are of what is held. ``low``, ``high`` (n, 3):
    bounds of the surfaces. ``origin``, ``counts``, ``strides`` (n, 3) and ``start`` (n,): the
    grids, whose ``cells`` lie one after another. ``R_base`` (3, 3), ``p_base`` (3,): the base in
    the world. ``tables`` (m, 4): two joints, where the cells of the table begin in ``blocked``, and
    how many are in a row; ``table_low``, ``table_scale``, ``table_last`` (m, 2): its lowest
    positions, cells a radian, and numbers of the last cells.
    """

    checks: UIntArray
    held: int
    low: Array
    high: Array
    origin: Array
    counts: Array
    strides: UIntArray
    start: UIntArray
    cells: npt.NDArray[np.uint8]
    R_base: Array
    p_base: Array
    tables: UIntArray
    table_low: Array
    table_scale: Array
    table_last: Array
    blocked: npt.NDArray[np.bool_]


class ChainArrays(NamedTuple):
    """A serial arm. Joint i's frame in its parent is ``A + sin(q) B + cos(q) C``, moved by ``t``.

    ``A``, ``B``, ``C`` (dof, 3, 3); ``t`` (dof, 3); ``axis`` (dof, 3): joint axis in the link;
    ``slide`` (dof, 3): translation in the parent per unit of a prismatic joint, else 0. ``tool``
    (3, 4): tool frame in the last link. ``reach`` (dof,): how far the tool can be from a joint, m.
    ``fields``: what the arm must not touch of the robot itself.
    """

    A: Array
    B: Array
    C: Array
    t: Array
    axis: Array
    slide: Array
    tool: Array
    lower: Array
    upper: Array
    reach: Array
    fields: FieldArrays


class SphereArrays(NamedTuple):
    """Spheres in clusters in links, each level with a bounding sphere x, y, z, r.

    ``spheres`` (s, 4), ``clusters`` (c, 4), ``links`` (dof, 4) in link frames; sphere k of cluster
    c: ``cluster_start[c] <= k < cluster_start[c + 1]``; the same for ``link_start``.
    Groups are what self-collision is checked for: the links without fingers, the fingers, what is
    held: ``groups`` (dof + 2, 4), with clusters by ``group_start`` as links have them.
    ``up`` (3,): unit vector in the last link that should point up; ``min_up``: smallest allowed
    cosine of the angle between them.
    """

    spheres: Array
    clusters: Array
    cluster_start: IntArray
    links: Array
    link_start: IntArray
    groups: Array
    group_start: IntArray
    up: Array
    min_up: float


class WorldArrays(NamedTuple):
    """Primitives: ``centre`` (p, 3), ``rotation`` (p, 3, 3), ``half`` (p, 3), ``round`` (p,).

    A cylinder has ``round`` 1 and half = radius, radius, half height. ``low``, ``high`` (p, 3):
    axis-aligned bounds; all lie within ``lower``..``upper`` (3,).
    ``active_from``: links before this one are too short to reach anything.
    """

    centre: Array
    rotation: Array
    half: Array
    round: IntArray
    low: Array
    high: Array
    lower: Array
    upper: Array
    margin: float
    active_from: int


def chain_arrays(arm: ArmModel, T_world_base: Array) -> ChainArrays:
    """The arm's chain with its base at ``T_world_base`` (4, 4)."""
    links = [link for link in arm.links if link.coordinate >= 0]
    A, B, C, t, slide = [], [], [], [], []
    for link in links:
        P = T_world_base @ link.T_parent_joint if link.parent < 0 else link.T_parent_joint
        R, axis = P[:3, :3], link.axis
        x, y, z = axis
        K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        outer = np.outer(axis, axis)
        turning = 0.0 if link.prismatic else 1.0
        A.append(R @ outer if turning else R)
        B.append(turning * (R @ K))
        C.append(turning * (R @ (np.eye(3) - outer)))
        t.append(P[:3, 3])
        slide.append(R @ axis if link.prismatic else np.zeros(3))
    offsets = [np.linalg.norm(link.T_parent_joint[:3, 3]) for link in links[1:]]
    offsets.append(np.linalg.norm(arm.T_link_tool[:3, 3]))
    reach = np.cumsum(np.array(offsets)[::-1])[::-1]
    return ChainArrays(
        np.array(A),
        np.array(B),
        np.array(C),
        np.array(t),
        np.array([link.axis for link in links]),
        np.array(slide),
        np.ascontiguousarray(arm.T_link_tool[:3]),
        np.array(arm.lower),
        np.array(arm.upper),
        np.maximum(reach, 0.1),
        _field_arrays(arm, T_world_base),
    )


def _field_arrays(arm: ArmModel, T_world_base: Array) -> FieldArrays:
    """The robot's distance fields with its base at ``T_world_base`` (4, 4)."""
    fields = arm.fields
    frames = [arm.links[f.frame].coordinate if f.frame >= 0 else arm.dof for f in fields]
    checks = [
        (group, min(group, arm.dof - 1), number, frames[number])
        for number, field in enumerate(fields)
        for group in _groups_of(arm, field)
    ]
    counts = np.array([field.values.shape for field in fields], dtype=np.int64).reshape(-1, 3)
    strides = np.column_stack([counts[:, 1] * counts[:, 2], counts[:, 2], np.ones(len(fields))])
    cells = [field.values.ravel() for field in fields]
    return FieldArrays(
        # What is farthest out is the likeliest to touch.
        np.array(sorted(checks, reverse=True), dtype=np.uintp).reshape(-1, 4),
        len(fields),
        np.array([field.lower for field in fields]).reshape(-1, 3),
        np.array([field.upper for field in fields]).reshape(-1, 3),
        np.array([field.origin for field in fields]).reshape(-1, 3),
        counts.astype(np.float64),
        strides.astype(np.uintp),
        np.cumsum([0, *counts.prod(axis=1)]).astype(np.uintp),
        np.concatenate([*cells, np.zeros(1, dtype=np.uint8)]),
        np.ascontiguousarray(T_world_base[:3, :3]),
        np.array(T_world_base[:3, 3]),
        *_table_arrays(arm.tables),
    )


def _table_arrays(
    tables: Sequence[PairTable],
) -> tuple[UIntArray, Array, Array, Array, npt.NDArray[np.bool_]]:
    """What ``FieldArrays`` has of tables."""
    starts = np.cumsum([0, *(table.blocked.size for table in tables)])
    rows = [
        (*table.joints, start, table.blocked.shape[1])
        for table, start in zip(tables, starts, strict=False)
    ]
    return (
        np.array(rows, dtype=np.uintp).reshape(-1, 4),
        np.array([table.low for table in tables]).reshape(-1, 2),
        np.array([1.0 / table.cell for table in tables]).reshape(-1, 2),
        np.array([table.blocked.shape for table in tables], dtype=np.float64).reshape(-1, 2) - 1.0,
        np.concatenate([*(table.blocked.ravel() for table in tables), np.zeros(1, dtype=np.bool_)]),
    )


def _groups_of(arm: ArmModel, field: DistanceField) -> list[int]:
    """Groups of spheres that are checked against a field; what is held against every one."""
    coordinates = [arm.links[number].coordinate for number in field.links]
    return sorted({arm.dof if k < 0 else k for k in coordinates} | {arm.dof + 1})


class ArmSpheres:
    """The spheres of an arm; only those of the hand depend on its opening."""

    def __init__(self, arm: ArmModel) -> None:
        self._arm = arm
        self._hand = arm.links[arm.tool_link].coordinate
        self._members: list[list[Array]] = []
        for coordinate in range(arm.dof):
            own = [link.spheres for link in arm.links if link.coordinate == coordinate]
            self._members.append([] if coordinate == self._hand else _split(np.vstack(own)))

    def at(self, opening: float) -> SphereArrays:
        """With the fingers at ``opening`` (m)."""
        arm = self._arm
        placed = finger_transforms(arm.links, arm.gripper.drive(opening))
        hand = [link.spheres for link in arm.links if link.coordinate == self._hand]
        fingers = [_moved(arm.links[number].spheres, T) for number, T in placed.items()]
        own = list(self._members)
        own[self._hand] = _split(np.vstack(hand))
        groups = [*own, _split(np.vstack([np.zeros((0, 4)), *fingers])), []]
        members = list(own)
        members[self._hand] = own[self._hand] + groups[-2]
        clusters = [cluster for group in members for cluster in group]
        return SphereArrays(
            np.vstack(clusters),
            np.array([_bounding(cluster) for cluster in clusters]),
            np.cumsum([0, *(len(cluster) for cluster in clusters)], dtype=np.int64),
            np.array([_around(group) for group in members]),
            np.cumsum([0, *(len(group) for group in members)], dtype=np.int64),
            np.array([_around(group) for group in groups]),
            np.cumsum([0, *(len(group) for group in groups)], dtype=np.int64),
            np.array(arm.T_link_tool[:3, 2]),
            -1.0,
        )


def _around(clusters: list[Array]) -> Array:
    return _bounding(np.vstack(clusters)) if clusters else np.zeros(4)


class Cover(NamedTuple):
    """Spheres (k, 4) of a held object in its own frame, in clusters (c, 4) of ``sizes`` (c,)."""

    spheres: Array
    clusters: Array
    sizes: IntArray


def held_cover(shape: Shape) -> Cover:
    """The cover of a held object."""
    parts = _split(shape_spheres(shape, _HELD_CELL))
    return Cover(
        np.vstack(parts),
        np.array([_bounding(part) for part in parts]),
        np.array([len(part) for part in parts], dtype=np.int64),
    )


def with_held(
    bare: SphereArrays, cover: Cover, T_link_object: Array, up: Array, max_tilt: float
) -> SphereArrays:
    """``bare`` with a held object at ``T_link_object`` (4, 4) in the last link.

    ``up`` (3,): what points up in the last link while the object stands as it was taken;
    ``max_tilt``: its largest angle to the vertical, rad.
    """
    clusters = _moved(cover.clusters, T_link_object)
    links = bare.links.copy()
    links[-1] = _bounding(np.vstack([links[-1:], clusters]))
    link_start = bare.link_start.copy()
    link_start[-1] += len(clusters)
    groups, group_start = bare.groups.copy(), bare.group_start.copy()
    groups[-1] = _bounding(clusters)
    group_start[-1] += len(clusters)
    return SphereArrays(
        np.vstack([bare.spheres, _moved(cover.spheres, T_link_object)]),
        np.vstack([bare.clusters, clusters]),
        np.concatenate([bare.cluster_start, bare.cluster_start[-1] + np.cumsum(cover.sizes)]),
        links,
        link_start,
        groups,
        group_start,
        up,
        float(np.cos(max_tilt)),
    )


def _moved(spheres: Array, T: Array) -> Array:
    moved = np.array(spheres)
    moved[:, :3] = spheres[:, :3] @ T[:3, :3].T + T[:3, 3]
    return moved


def _split(spheres: Array) -> list[Array]:
    """Halve along the longest side until the clusters are small."""
    if not len(spheres):
        return []
    if len(spheres) <= _CLUSTER_SIZE:
        return [spheres]
    axis = int(np.argmax(np.ptp(spheres[:, :3], axis=0)))
    order = np.argsort(spheres[:, axis], kind="stable")
    half = len(spheres) // 2
    return _split(spheres[order[:half]]) + _split(spheres[order[half:]])


def _bounding(spheres: Array) -> Array:
    lower = (spheres[:, :3] - spheres[:, 3:]).min(axis=0)
    upper = (spheres[:, :3] + spheres[:, 3:]).max(axis=0)
    centre = (lower + upper) / 2.0
    radius = (np.linalg.norm(spheres[:, :3] - centre, axis=1) + spheres[:, 3]).max()
    return np.append(centre, radius)


def shape_spheres(shape: Shape, cell: float) -> Array:
    """Spheres (k, 4) covering the sides of a shape, flush with its top and bottom.

    They bulge sideways by under half a ``cell`` (m) but not upwards: a held object that was only
    just lifted would otherwise seem to touch the floor it stood on.
    """
    half = shape.size / 2.0 if isinstance(shape, Box) else np.full(3, shape.radius)
    half_height = shape.height / 2.0
    counts = [max(1, int(np.ceil(2.0 * h / cell))) for h in (half[0], half[1])]
    xs, ys = ((np.arange(n) + 0.5) * (2.0 * h / n) - h for n, h in zip(counts, half, strict=False))
    x, y = (g.ravel() for g in np.meshgrid(xs, ys, indexing="ij"))
    rim = cell
    if isinstance(shape, Box):
        shell = (np.abs(x) > half[0] - rim) | (np.abs(y) > half[1] - rim)
    else:
        distance = np.hypot(x, y)
        shell = (distance > shape.radius - 1.5 * rim) & (distance < shape.radius + 0.3 * rim)
    radius = cell * np.sqrt(3.0) / 2.0
    layers = max(2, int(np.ceil((2.0 * half_height) / cell)))
    zs = np.linspace(-half_height + radius, half_height - radius, layers)
    columns = np.column_stack([x[shell], y[shell]])
    return np.array([[cx, cy, z, radius] for cx, cy in columns for z in zs])
