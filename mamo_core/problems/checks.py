"""Does a problem make sense? Every complaint names the object, the value and what is allowed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from mamo_core.problems.footprints import extents, footprint, separation
from mamo_core.types.geometry import Array, Box, Shape, matrix_from_pose, z_axes
from mamo_core.types.problem import Problem

DEEPEST_OVERLAP = 0.001
"""Objects may share this much at the start: measured scenes touch, m."""

FLOOR_TOLERANCE = 0.001
"""How far (m) an object's bottom may be from the floor."""

UPRIGHT_TOLERANCE = 1e-3
"""Largest initial tilt, rad."""


class Complaint(NamedTuple):
    """``message`` about object number ``place`` of the scene."""

    place: int
    message: str


def complaints(problem: Problem) -> list[Complaint]:
    """Everything about the initial state that no plan could mend."""
    standing = list(_standing(problem))
    if standing:
        # Distances between footprints mean something for upright objects alone.
        return standing
    return [*_outside(problem), *_in_fixtures(problem), *_overlapping(problem)]


def _standing(problem: Problem) -> Iterator[Complaint]:
    floor = problem.scene.workspace.floor
    axes = z_axes(problem.initial.object_poses)
    for i, (item, pose) in enumerate(_items(problem)):
        tilt = float(np.arccos(np.clip(axes[i, 2], -1.0, 1.0)))
        if tilt > UPRIGHT_TOLERANCE:
            yield Complaint(i, f"object {item!r} is tilted by {tilt:.3g} rad, expected upright")
            continue
        bottom = pose[2] - problem.scene.objects[i].shape.height / 2.0
        if abs(bottom - floor) > FLOOR_TOLERANCE:
            side = "below" if bottom < floor else "above"
            yield Complaint(
                i,
                f"object {item!r} has its bottom at z = {bottom:.4g} m, {side} the floor; expected "
                f"{floor:.4g} m (position z = {floor + pose[2] - bottom:.4g})",
            )


def _outside(problem: Problem) -> Iterator[Complaint]:
    space = problem.scene.workspace
    lower = space.lower[:2] - [space.overhang, 0.0]
    upper = space.upper[:2]
    for i, (name, pose) in enumerate(_items(problem)):
        shape = problem.scene.objects[i].shape
        box = np.array(extents(footprint(shape, pose)))
        slack = DEEPEST_OVERLAP
        if (box[:2] < lower - slack).any() or (box[2:] > upper + slack).any():
            yield Complaint(
                i,
                f"object {name!r} covers x {box[0]:.3f}..{box[2]:.3f}, y {box[1]:.3f}.."
                f"{box[3]:.3f} m, outside the workspace x {lower[0]:.3f}..{upper[0]:.3f}, "
                f"y {lower[1]:.3f}..{upper[1]:.3f} m",
            )
        top = pose[2] + shape.height / 2.0
        if top > space.upper[2] + slack:
            yield Complaint(
                i,
                f"object {name!r} reaches up to z = {top:.3f} m, above the workspace's "
                f"{space.upper[2]:.3f} m",
            )


def _in_fixtures(problem: Problem) -> Iterator[Complaint]:
    for i, (name, pose) in enumerate(_items(problem)):
        for fixture in problem.scene.fixtures:
            depth = penetration(problem.scene.objects[i].shape, pose, fixture.shape, fixture.pose)
            if depth > DEEPEST_OVERLAP:
                yield Complaint(
                    i, f"object {name!r} is {1000 * depth:.1f} mm inside fixture {fixture.name!r}"
                )


def _overlapping(problem: Problem) -> Iterator[Complaint]:
    items = list(_items(problem))
    shapes = [item.shape for item in problem.scene.objects]
    for j in range(len(items)):
        for i in range(j):
            depth = penetration(shapes[i], items[i][1], shapes[j], items[j][1])
            if depth > DEEPEST_OVERLAP:
                yield Complaint(
                    j,
                    f"objects {items[i][0]!r} and {items[j][0]!r} overlap by "
                    f"{1000 * depth:.1f} mm, expected at most {1000 * DEEPEST_OVERLAP:.0f} mm",
                )


def _items(problem: Problem) -> Iterator[tuple[str, Array]]:
    names = (item.name for item in problem.scene.objects)
    return zip(names, problem.initial.object_poses, strict=True)


def penetration(shape_a: Shape, pose_a: Array, shape_b: Shape, pose_b: Array) -> float:
    """Shortest way (m) to part two solids at poses (7,), world; 0 if they do not overlap."""
    if not (_upright(pose_a) and _upright(pose_b)):
        return _tilted_penetration(shape_a, pose_a, shape_b, pose_b)
    vertical = (shape_a.height + shape_b.height) / 2.0 - abs(pose_a[2] - pose_b[2])
    apart = math.hypot(pose_a[0] - pose_b[0], pose_a[1] - pose_b[1])
    if vertical <= 0.0 or apart >= shape_a.footprint_radius + shape_b.footprint_radius:
        return 0.0
    horizontal = -separation(footprint(shape_a, pose_a), footprint(shape_b, pose_b)).distance
    return max(0.0, min(float(vertical), horizontal))


def _upright(pose: Array) -> bool:
    return 2.0 * float(np.hypot(pose[4], pose[5])) < UPRIGHT_TOLERANCE


def _tilted_penetration(shape_a: Shape, pose_a: Array, shape_b: Shape, pose_b: Array) -> float:
    """The same for any orientation, such as a ramp among the fixtures."""
    import fcl

    solids = [_fcl_object(fcl, s, p) for s, p in ((shape_a, pose_a), (shape_b, pose_b))]
    request = fcl.CollisionRequest(num_max_contacts=100, enable_contact=True)
    result = fcl.CollisionResult()
    fcl.collide(*solids, request, result)
    return max((float(c.penetration_depth) for c in result.contacts), default=0.0)


def _fcl_object(fcl: Any, shape: Shape, pose: Array) -> Any:
    T = matrix_from_pose(pose)
    solid = (
        fcl.Box(*shape.size) if isinstance(shape, Box) else fcl.Cylinder(shape.radius, shape.height)
    )
    return fcl.CollisionObject(solid, fcl.Transform(T[:3, :3], T[:3, 3]))
