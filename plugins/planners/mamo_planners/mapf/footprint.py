"""What an object covers of the floor: points (their convex hull) widened by a radius.

An upright box is its four corners, an upright cylinder one point and its radius. A tilted object
is taken larger than it is: a box as the hull of its eight projected corners and of its upright
rectangle, a cylinder as the stadium around its projected axis. So a path that is valid for the
footprint is valid for the object.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, hypot, sin
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from mamo_core.types.geometry import Array, Box, Cylinder, Shape, rotation_from_quat
from mamo_planners.mapf.convex import hull

LEVEL = 1e-9
"""sin^2 of half the tilt up to which a body counts as upright (about 0.004 degrees)."""


@dataclass(frozen=True, eq=False)
class Footprint:
    """``points`` (k, 2) relative to the pose's xy and ``radius`` around their hull, metres.

    ``bottom`` and ``top``: heights (m, world) between which the object stands.
    """

    points: Array
    radius: float
    bottom: float
    top: float

    def lower(self) -> Array:
        """Least x and y (2,), relative to the pose, metres."""
        return self.points.min(axis=0) - self.radius

    def upper(self) -> Array:
        """Largest x and y (2,), relative to the pose, metres."""
        return self.points.max(axis=0) + self.radius


def footprint_of(shape: Shape, pose: npt.ArrayLike) -> Footprint:
    """The footprint of ``shape`` at ``pose`` (7,), conservative if it is tilted."""
    values = np.asarray(pose, dtype=np.float64)
    _, _, z, w, x, y, quat_z = values.tolist()
    tilted = (x * x + y * y) > LEVEL * (w * w + x * x + y * y + quat_z * quat_z)
    rotation = rotation_from_quat(values[3:]) if tilted else None
    if isinstance(shape, Box):
        yaw = 2.0 * atan2(quat_z, w)
        if rotation is not None:
            yaw = atan2(rotation[1, 0], rotation[0, 0])
        return _box(shape, z, yaw, rotation)
    return _cylinder(shape, z, rotation)


def _box(shape: Box, z: float, yaw: float, rotation: Array | None) -> Footprint:
    hx, hy, hz = (shape.size / 2.0).tolist()
    c, s = cos(yaw), sin(yaw)
    corners = [(hx, hy), (-hx, hy), (-hx, -hy), (hx, -hy)]
    points = np.array([(c * u - s * v, s * u + c * v) for u, v in corners])
    if rotation is None:
        return Footprint(points, 0.0, z - hz, z + hz)
    signs = np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)])
    points = np.concatenate([points, (signs * shape.size / 2.0) @ rotation[:2].T])
    reach_z = max(hz, float(np.abs(rotation[2]) @ shape.size) / 2.0)
    return Footprint(hull(points, len(points)), 0.0, z - reach_z, z + reach_z)


def _cylinder(shape: Cylinder, z: float, rotation: Array | None) -> Footprint:
    half = shape.height / 2.0
    if rotation is None:
        return Footprint(np.zeros((1, 2)), shape.radius, z - half, z + half)
    axis = rotation[:, 2]
    ends = np.stack([axis[:2] * half, -axis[:2] * half])
    lean = hypot(axis[0], axis[1])
    reach_z = max(half, half * abs(float(axis[2])) + shape.radius * lean)
    return Footprint(ends, shape.radius, z - reach_z, z + reach_z)


def grown(shape: Shape, amount: float) -> Shape:
    """The shape ``amount`` (m) wider on every side, as high as before."""
    if isinstance(shape, Box):
        return Box(shape.size + np.array([2.0 * amount, 2.0 * amount, 0.0]))
    return Cylinder(shape.radius + amount, shape.height)


class FootprintArrays(NamedTuple):
    """Footprints side by side, as the kernels take them; n of them, world frame.

    ``points`` (n, k, 2) m relative to ``position`` (n, 2); ``sizes`` (n,) of them are used;
    ``radius``, ``bottom``, ``top`` (n,) m.
    """

    position: Array
    points: Array
    sizes: npt.NDArray[np.int64]
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
