"""What an object covers of the floor: points (their convex hull) widened by a radius.

An upright box is its four corners, an upright cylinder one point and its radius. A tilted object
is taken larger than it is: a box as the hull of its eight projected corners and of its upright
rectangle, a cylinder as the stadium around its projected axis. So a path that is valid for the
footprint is valid for the object.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from mamo_core.types.geometry import Array, Cylinder, Shape, rotation_from_quat, yaw_of
from mamo_planners.mapf.convex import hull

UPRIGHT = 1.0 - 1e-9
"""Cosine of the tilt from which a body counts as upright (about 0.003 degrees)."""


@dataclass(frozen=True, eq=False)
class Footprint:
    """``points`` (k, 2) relative to the pose's xy and ``radius`` around their hull, metres.

    ``bottom`` and ``top``: heights (m, world) between which the object stands. ``corner``: how
    far (in units of a growth) the corners move when the shape grows: sqrt(2) for boxes.
    """

    points: Array
    radius: float
    bottom: float
    top: float
    corner: float = 1.0

    def lower(self) -> Array:
        """Least x and y (2,), relative to the pose, metres."""
        return self.points.min(axis=0) - self.radius

    def upper(self) -> Array:
        """Largest x and y (2,), relative to the pose, metres."""
        return self.points.max(axis=0) + self.radius


def footprint_of(shape: Shape, pose: npt.ArrayLike) -> Footprint:
    """The footprint of ``shape`` at ``pose`` (7,), conservative if it is tilted."""
    values = np.asarray(pose, dtype=np.float64)
    R = rotation_from_quat(values[3:])
    if isinstance(shape, Cylinder):
        return _cylinder(shape, values[2], R[:, 2])
    half = shape.size / 2.0
    upright = _rectangle(half[0], half[1], yaw_of(values))
    reach_z = half[2]
    if abs(R[2, 2]) < UPRIGHT:
        signs = np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)])
        points = np.concatenate([upright, (signs * half) @ R[:2].T])
        upright = hull(points, len(points))
        reach_z = max(half[2], float(np.abs(R[2]) @ half))
    return Footprint(upright, 0.0, values[2] - reach_z, values[2] + reach_z, np.sqrt(2.0))


def _rectangle(hx: float, hy: float, yaw: float) -> Array:
    c, s = np.cos(yaw), np.sin(yaw)
    corners = np.array([[hx, hy], [-hx, hy], [-hx, -hy], [hx, -hy]])
    return corners @ np.array([[c, s], [-s, c]])


def _cylinder(shape: Cylinder, z: float, axis: Array) -> Footprint:
    half = shape.height / 2.0
    if abs(axis[2]) >= UPRIGHT:
        return Footprint(np.zeros((1, 2)), shape.radius, z - half, z + half)
    ends = np.stack([axis[:2] * half, -axis[:2] * half])
    lean = float(np.hypot(axis[0], axis[1]))
    reach_z = max(half, half * abs(float(axis[2])) + shape.radius * lean)
    return Footprint(ends, shape.radius, z - reach_z, z + reach_z)


def grown(footprint: Footprint, amount: float) -> Footprint:
    """A footprint that holds the object's when ``Box`` sides or ``Cylinder`` radius grow.

    ``amount`` (m) is what each side grows by; a box's corners then move by sqrt(2) of it.
    """
    return replace(footprint, radius=footprint.radius + amount * footprint.corner)


class FootprintArrays(NamedTuple):
    """Footprints side by side, as the kernels take them; n of them, world frame.

    ``points`` (n, k, 2) m relative to ``position`` (n, 2); ``count`` (n,) of them are used;
    ``radius``, ``bottom``, ``top`` (n,) m.
    """

    position: Array
    points: Array
    count: npt.NDArray[np.int64]
    radius: Array
    bottom: Array
    top: Array


def pack(footprints: list[Footprint], positions: list[Array]) -> FootprintArrays:
    """Footprints and their world xy (2,) in arrays."""
    n = len(footprints)
    width = max((len(f.points) for f in footprints), default=1)
    points = np.zeros((n, width, 2))
    for row, footprint in zip(points, footprints, strict=True):
        row[: len(footprint.points)] = footprint.points
    return FootprintArrays(
        np.array(positions, dtype=np.float64).reshape(n, 2),
        points,
        np.array([len(f.points) for f in footprints], dtype=np.int64),
        np.array([f.radius for f in footprints], dtype=np.float64),
        np.array([f.bottom for f in footprints], dtype=np.float64),
        np.array([f.top for f in footprints], dtype=np.float64),
    )
