"""The flat arrays the compiled kernels work on, and how they are made from models and scenes."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from mamo_core.robots.kinematics import finger_transforms
from mamo_core.robots.model import ArmModel, LinkModel
from mamo_core.types.geometry import Array, Box, IntArray, Shape, matrix_from_pose
from mamo_core.types.scene import Scene

_CLUSTER_SIZE = 24
_HELD_CELL = 0.012


class ChainArrays(NamedTuple):
    """A serial arm. Joint i's frame in its parent is ``A + sin(q) B + cos(q) C``, moved by ``t``.

    ``A``, ``B``, ``C`` (dof, 3, 3); ``t`` (dof, 3); ``axis`` (dof, 3): joint axis in the link;
    ``slide`` (dof, 3): translation in the parent per unit of a prismatic joint, else 0. ``tool``
    (3, 4): tool frame in the last link. ``reach`` (dof,): how far the tool can be from a joint, m.
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


class SphereArrays(NamedTuple):
    """Spheres in clusters in links, each level with a bounding sphere x, y, z, r.

    ``spheres`` (s, 4), ``clusters`` (c, 4), ``links`` (dof, 4) in link frames; sphere k of cluster
    c: ``cluster_start[c] <= k < cluster_start[c + 1]``; the same for ``link_start``.
    ``up`` (3,): unit vector in the last link that should point up; ``min_up``: smallest allowed
    cosine of the angle between them.
    """

    spheres: Array
    clusters: Array
    cluster_start: IntArray
    links: Array
    link_start: IntArray
    up: Array
    min_up: float


class WorldArrays(NamedTuple):
    """Primitives: ``centre`` (p, 3), ``rotation`` (p, 3, 3), ``half`` (p, 3), ``round`` (p,).

    A cylinder has ``round`` 1 and half = radius, radius, half height. ``low``, ``high`` (p, 3):
    axis-aligned bounds. ``first_link`` (p,): earlier links are not checked. The first ``body``
    primitives are the robot's own; all others lie within ``lower``..``upper`` (3,).
    ``active_from``: links before this one are too short to reach anything.
    """

    centre: Array
    rotation: Array
    half: Array
    round: IntArray
    low: Array
    high: Array
    first_link: IntArray
    body: int
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
    )


def sphere_arrays(arm: ArmModel, opening: float) -> SphereArrays:
    """The arm's spheres with the fingers at ``opening`` (m)."""
    fingers = finger_transforms(arm.links, arm.gripper.drive(opening))
    groups: list[list[Array]] = [[] for _ in range(arm.dof)]
    for number, link in enumerate(arm.links):
        if link.coordinate >= 0:
            groups[link.coordinate].append(link.spheres)
        else:
            carrier = arm.links[arm.tool_link].coordinate
            groups[carrier].append(_moved(link.spheres, fingers[number]))
    members = [_split(np.vstack(group)) for group in groups]
    clusters = [cluster for group in members for cluster in group]
    return SphereArrays(
        np.vstack(clusters),
        np.array([_bounding(cluster) for cluster in clusters]),
        np.cumsum([0, *(len(cluster) for cluster in clusters)], dtype=np.int64),
        np.array([_bounding(np.vstack(group)) if group else np.zeros(4) for group in members]),
        np.cumsum([0, *(len(group) for group in members)], dtype=np.int64),
        np.array(arm.T_link_tool[:3, 2]),
        -1.0,
    )


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
    return SphereArrays(
        np.vstack([bare.spheres, _moved(cover.spheres, T_link_object)]),
        np.vstack([bare.clusters, clusters]),
        np.concatenate([bare.cluster_start, bare.cluster_start[-1] + np.cumsum(cover.sizes)]),
        links,
        link_start,
        up,
        float(np.cos(max_tilt)),
    )


def _moved(spheres: Array, T: Array) -> Array:
    return np.column_stack([spheres[:, :3] @ T[:3, :3].T + T[:3, 3], spheres[:, 3]])


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


def world_arrays(
    scene: Scene,
    arm: ArmModel,
    object_poses: Array,
    ignore: Collection[str],
    margin: float,
) -> WorldArrays:
    """Fixtures, the robot's own body and the objects, but for those in ``ignore``."""
    T_world_base = matrix_from_pose(scene.T_world_base)
    items: list[tuple[Array, Shape, int]] = [
        (T_world_base @ b.T_base_box, Box(b.size), b.first_link) for b in arm.body
    ]
    body = len(items)
    items += [
        (matrix_from_pose(f.pose), f.shape, 0) for f in scene.fixtures if f.name not in ignore
    ]
    items += [
        (matrix_from_pose(pose), o.shape, 0)
        for o, pose in zip(scene.objects, object_poses, strict=True)
        if o.name not in ignore
    ]
    half = np.array([_half_extents(shape) for _, shape, _ in items]).reshape(-1, 3)
    centre = np.array([T[:3, 3] for T, _, _ in items]).reshape(-1, 3)
    rotation = np.array([T[:3, :3] for T, _, _ in items]).reshape(-1, 3, 3)
    spread = np.einsum("pij,pj->pi", np.abs(rotation), half)
    low, high = centre - spread, centre + spread
    around = slice(body, None)
    empty = len(items) == body
    return WorldArrays(
        centre,
        rotation,
        half,
        np.array([0 if isinstance(s, Box) else 1 for _, s, _ in items], dtype=np.int64),
        low,
        high,
        np.array([first for _, _, first in items], dtype=np.int64),
        body,
        np.zeros(3) if empty else low[around].min(axis=0),
        np.zeros(3) if empty else high[around].max(axis=0),
        margin,
        _first_active(arm, T_world_base, low, high, [first for _, _, first in items], margin),
    )


def _first_active(
    arm: ArmModel,
    T_world_base: Array,
    low: Array,
    high: Array,
    first_links: list[int],
    margin: float,
) -> int:
    """The first link that, stretched out from the first joint, could touch what it is checked for.

    Only for arms that turn: a slide moves its root, so nothing is skipped there.
    """
    links = [link for link in arm.links if link.coordinate >= 0]
    if any(link.prismatic for link in links):
        return 0
    T_root = T_world_base @ links[0].T_parent_joint
    own_low, own_high = _turned_bounds(links[0], T_root)
    around = np.all((low - margin <= own_high) & (high + margin >= own_low), axis=1)
    if (around & (np.array(first_links) == 0)).any():
        return 0
    root = T_root[:3, 3]
    gaps = np.linalg.norm(np.maximum(np.maximum(low - root, root - high), 0.0), axis=1)
    stretch = 0.0
    for number, link in enumerate(links[1:], start=1):
        stretch += float(np.linalg.norm(link.T_parent_joint[:3, 3]))
        own = np.linalg.norm(link.spheres[:, :3], axis=1) + link.spheres[:, 3]
        reach = stretch + float(own.max(initial=0.0)) + margin
        near = [g for g, first in zip(gaps, first_links, strict=True) if first <= number]
        if number == len(links) - 1 or any(gap <= reach for gap in near):
            return number
    return 0


def _turned_bounds(link: LinkModel, T: Array) -> tuple[Array, Array]:
    """Axis-aligned bounds (3,), (3,) of a link that turns all around its axis at ``T`` (4, 4)."""
    axis = T[:3, :3] @ link.axis
    along = link.spheres[:, :3] @ link.axis
    away = np.linalg.norm(link.spheres[:, :3] - along[:, None] * link.axis, axis=1)
    middle = T[:3, 3] + along[:, None] * axis
    spread = away[:, None] * np.sqrt(np.maximum(1.0 - axis**2, 0.0)) + link.spheres[:, 3:]
    return (middle - spread).min(axis=0), (middle + spread).max(axis=0)


def _half_extents(shape: Shape) -> Array:
    if isinstance(shape, Box):
        return shape.size / 2.0
    return np.array([shape.radius, shape.radius, shape.height / 2.0])
