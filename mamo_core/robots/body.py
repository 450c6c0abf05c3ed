"""The robot beside its arm, and what may collide with what, while an arm is built."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from mamo_core.robots.distance_field import DistanceField, measure_field
from mamo_core.robots.model import ArmModel, BodyPart, LinkModel
from mamo_core.robots.pair_table import measure_table
from mamo_core.robots.self_pairs import PairFacts, Solid, measure_pairs
from mamo_core.types.geometry import Array

_SLAB = 0.2
"""The hull of a large part would fill the hollows the arm moves in: it is cut in slabs, m."""

_FAR = 0.02
"""A part that is not checked against a link does no harm in its field from this distance on, m."""


def body_parts(pieces: Mapping[str, Sequence[Any]], folder: Path) -> tuple[BodyPart, ...]:
    """Write meshes and hulls of ``pieces``: trimeshes in the base frame, by name of the part."""
    parts = []
    for name, meshes in pieces.items():
        stls, objs = [], []
        for k, mesh in enumerate(meshes):
            stls.append(folder / f"body_{name}_{k}.stl")
            mesh.export(stls[-1])
            for n, hull in enumerate(convex_slabs(mesh)):
                objs.append(folder / f"body_{name}_{k}_{n}.obj")
                hull.export(objs[-1], digits=9)
        parts.append(BodyPart(name, tuple(objs), tuple(stls)))
    return tuple(parts)


def convex_slabs(mesh: Any) -> list[Any]:
    """Convex pieces that contain a mesh: hulls of slabs, cut where they are smallest in total."""
    if mesh.extents.max() <= 2.0 * _SLAB:
        return [mesh.convex_hull]
    cuts = [_slabs(mesh, axis) for axis in range(3) if mesh.extents[axis] > _SLAB]
    return min(cuts, key=lambda hulls: round(sum(float(hull.volume) for hull in hulls), 6))


def _slabs(mesh: Any, axis: int) -> list[Any]:
    import trimesh

    low, high = mesh.bounds[:, axis]
    walls = np.linspace(low, high, int(np.ceil((high - low) / _SLAB)) + 1)
    hulls = []
    for below, above in pairwise(walls):
        heights = mesh.vertices[:, axis]
        corners = mesh.vertices[(heights >= below) & (heights <= above)]
        points = [corners, _crossings(mesh, axis, below), _crossings(mesh, axis, above)]
        hulls.append(trimesh.PointCloud(np.vstack(points)).convex_hull)
    return hulls


def _crossings(mesh: Any, axis: int, height: float) -> Array:
    """Where edges cross a plane (k, 3)."""
    a, b = mesh.vertices[mesh.edges_unique].transpose(1, 0, 2)
    crossing = (a[:, axis] - height) * (b[:, axis] - height) < 0.0
    a, b = a[crossing], b[crossing]
    found: Array = a + (b - a) * ((height - a[:, axis]) / (b[:, axis] - a[:, axis]))[:, None]
    return found


def with_self_collision(arm: ArmModel, mount: str) -> ArmModel:
    """The arm with its pairs and fields; ``mount``: the body part the arm begins at."""
    solids = [_solid(part) for part in arm.parts]
    facts = measure_pairs(arm, solids, [mount])
    close = [f for f in facts if f.checked and f.tabled and f.other < len(arm.links)]
    tables = tuple(measure_table(arm, f.one, f.other, solids) for f in close)
    open_facts = [f for f in facts if f not in close]
    return replace(
        arm,
        self_pairs=tuple((f.one, f.other) for f in facts if f.checked),
        hull_pairs=tuple((f.one, f.other) for f in facts if f.for_engines),
        fields=(*_body_fields(arm, solids, open_facts), *_link_fields(arm, solids, open_facts)),
        tables=tables,
    )


def _solid(part: LinkModel | BodyPart) -> Solid:
    import trimesh

    meshes, hulls = (
        tuple(trimesh.load(path, force="mesh") for path in paths)
        for paths in (part.meshes, part.hulls)
    )
    return Solid(part.name, meshes, hulls)


def _body_fields(
    arm: ArmModel, solids: Sequence[Solid], facts: Sequence[PairFacts]
) -> list[DistanceField]:
    """One for each set of body parts that links are checked against.

    Links whose pairs need no check may share a field if they never come near.
    """
    links, everything = len(arm.links), frozenset(range(len(arm.links), len(solids)))
    by_parts: dict[frozenset[int], list[int]] = {}
    for link in range(links):
        own = [f for f in facts if f.one == link and f.other >= links]
        if any(f.checked for f in own):
            close = {f.other for f in own if not f.checked and f.apart < _FAR}
            by_parts.setdefault(everything - close, []).append(link)
    return [
        measure_field(-1, tuple(checked), *_geometry(solids, sorted(parts), facts))
        for parts, checked in by_parts.items()
    ]


def _link_fields(
    arm: ArmModel, solids: Sequence[Solid], facts: Sequence[PairFacts]
) -> list[DistanceField]:
    """One for each link but the hand's, which what is held may touch, too."""
    fields = []
    for other, link in enumerate(arm.links):
        if 0 <= link.coordinate < arm.links[arm.tool_link].coordinate and solids[other].meshes:
            checked = tuple(f.one for f in facts if f.other == other and f.checked)
            fields.append(measure_field(other, checked, *_geometry(solids, [other], facts)))
    return fields


def _geometry(
    solids: Sequence[Solid], parts: Sequence[int], facts: Sequence[PairFacts]
) -> tuple[list[Any], list[Any]]:
    """Surfaces and convex solids: hulls where engines see them, so that both agree, else meshes."""
    surfaces: list[Any] = []
    hulls: list[Any] = []
    for part in parts:
        own = [f for f in facts if f.other == part and f.checked]
        if own and all(f.for_engines for f in own):
            hulls += solids[part].hulls
        else:
            surfaces += solids[part].meshes
    return surfaces, hulls
