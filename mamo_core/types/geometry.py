"""Shapes, poses and the few rigid-body functions that everything else shares.

A pose is a read-only array (7,): x, y, z in metres, then the unit quaternion w, x, y, z.
A transform is an array (4, 4). Frames stand in the name: ``T_world_tool`` maps tool to world.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


def frozen_array(value: npt.ArrayLike, name: str, shape: tuple[int | None, ...]) -> Array:
    """A read-only float64 copy of ``value``; ``None`` in ``shape`` allows any length there.

    Raises:
        ValueError: wrong shape, or a value that is NaN or infinite.
    """
    array = np.array(value, dtype=np.float64)
    fits = array.ndim == len(shape) and all(
        want is None or want == have for want, have in zip(shape, array.shape, strict=False)
    )
    if not fits:
        wanted = "(" + ", ".join("any" if n is None else str(n) for n in shape) + ")"
        raise ValueError(f"{name}: shape {array.shape}, expected {wanted}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: {array.tolist()} holds NaN or infinity, expected finite numbers")
    array.flags.writeable = False
    return array


def positive(value: float, name: str) -> float:
    """``value`` as a float, if it is finite and above zero.

    Raises:
        ValueError: otherwise.
    """
    number = float(value)
    if not (np.isfinite(number) and number > 0.0):
        raise ValueError(f"{name}: {value}, expected a finite number above 0")
    return number


@dataclass(frozen=True, eq=False)
class Box:
    """A cuboid centred at its frame; ``size`` (3,) holds the FULL extents in metres."""

    size: Array

    def __post_init__(self) -> None:
        size = frozen_array(self.size, "box size", (3,))
        for value in size:
            positive(value, "box size")
        object.__setattr__(self, "size", size)

    @property
    def height(self) -> float:
        """Extent along z, metres."""
        return float(self.size[2])

    @property
    def footprint_radius(self) -> float:
        """Radius of the circle around the footprint, metres."""
        return float(np.hypot(self.size[0], self.size[1]) / 2.0)


@dataclass(frozen=True)
class Cylinder:
    """A cylinder along z, centred at its frame; ``height`` is the full height, metres."""

    radius: float
    height: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", positive(self.radius, "cylinder radius"))
        object.__setattr__(self, "height", positive(self.height, "cylinder height"))

    @property
    def footprint_radius(self) -> float:
        """Radius of the footprint, metres."""
        return self.radius


Shape = Box | Cylinder


def make_pose(position: npt.ArrayLike, yaw: float = 0.0) -> Array:
    """The pose at ``position`` (3,) metres, turned by ``yaw`` radians about world z."""
    x, y, z = np.asarray(position, dtype=np.float64)
    return frozen_array([x, y, z, np.cos(yaw / 2.0), 0.0, 0.0, np.sin(yaw / 2.0)], "pose", (7,))


def rotation_from_quat(quat_wxyz: npt.ArrayLike) -> Array:
    """Rotation matrix (3, 3) of a quaternion (normalised here)."""
    quat = np.asarray(quat_wxyz, dtype=np.float64)
    w, x, y, z = (quat / math.sqrt(quat.dot(quat))).tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def rotations_from_quats(quats_wxyz: npt.ArrayLike) -> Array:
    """Rotation matrices (n, 3, 3) of quaternions (n, 4), normalised here."""
    quats = np.asarray(quats_wxyz, dtype=np.float64)
    w, x, y, z = (quats / np.linalg.norm(quats, axis=1)[:, None]).T
    R = np.empty((len(quats), 3, 3))
    R[:, 0, 0], R[:, 0, 1] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z)
    R[:, 1, 1], R[:, 1, 2] = 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    R[:, 2, 2], R[:, 2, 0] = 1 - 2 * (x * x + y * y), 2 * (x * z - w * y)
    R[:, 1, 0], R[:, 0, 2] = 2 * (x * y + w * z), 2 * (x * z + w * y)
    R[:, 2, 1] = 2 * (y * z + w * x)
    return R


def quat_from_rotation(rotation: npt.ArrayLike) -> Array:
    """Unit quaternion w, x, y, z (w >= 0) of a rotation matrix (3, 3)."""
    R = np.asarray(rotation, dtype=np.float64)
    K = np.array(
        [
            [R[0, 0] - R[1, 1] - R[2, 2], 0.0, 0.0, 0.0],
            [R[0, 1] + R[1, 0], R[1, 1] - R[0, 0] - R[2, 2], 0.0, 0.0],
            [R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], R[2, 2] - R[0, 0] - R[1, 1], 0.0],
            [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], np.trace(R)],
        ]
    )
    _, vectors = np.linalg.eigh(K)
    x, y, z, w = vectors[:, 3]
    quat = np.array([w, x, y, z])
    return -quat if w < 0.0 else quat


def matrix_from_pose(pose: npt.ArrayLike) -> Array:
    """Transform (4, 4) of a pose (7,)."""
    values = np.asarray(pose, dtype=np.float64)
    T = np.zeros((4, 4))
    T[:3, :3] = rotation_from_quat(values[3:])
    T[:3, 3] = values[:3]
    T[3, 3] = 1.0
    return T


def matrices_from_poses(poses: npt.ArrayLike) -> Array:
    """Transforms (n, 4, 4) of poses (n, 7)."""
    values = np.asarray(poses, dtype=np.float64)
    T = np.zeros((len(values), 4, 4))
    T[:, :3, :3] = rotations_from_quats(values[:, 3:])
    T[:, :3, 3] = values[:, :3]
    T[:, 3, 3] = 1.0
    return T


def pose_from_matrix(T: npt.ArrayLike) -> Array:
    """Pose (7,) of a transform (4, 4)."""
    matrix = np.asarray(T, dtype=np.float64)
    values = np.concatenate([matrix[:3, 3], quat_from_rotation(matrix[:3, :3])])
    return frozen_array(values, "pose", (7,))


def invert(T: npt.ArrayLike) -> Array:
    """Inverse of a rigid transform (4, 4)."""
    matrix = np.asarray(T, dtype=np.float64)
    inverse = np.eye(4)
    inverse[:3, :3] = matrix[:3, :3].T
    inverse[:3, 3] = -matrix[:3, :3].T @ matrix[:3, 3]
    return inverse


def yaw_of(pose: npt.ArrayLike) -> float:
    """Heading of the body's x axis in the world's xy plane, radians."""
    R = rotation_from_quat(np.asarray(pose, dtype=np.float64)[3:])
    return float(np.arctan2(R[1, 0], R[0, 0]))


def z_axes(poses: npt.ArrayLike) -> Array:
    """World directions (n, 3) of the z axes of poses (n, 7)."""
    quats = np.asarray(poses, dtype=np.float64)[:, 3:]
    w, x, y, z = quats.T
    return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)


def tool_matrix(position: npt.ArrayLike, yaw: float, pitch: float = 0.0) -> Array:
    """Transform (4, 4) whose x axis points along ``yaw``, dipped by ``pitch`` (down positive)."""
    return tool_matrices(np.asarray(position)[None], np.array([yaw]), np.array([pitch]))[0]


def tool_matrices(positions: npt.ArrayLike, yaws: Array, pitches: Array) -> Array:
    """Transforms (n, 4, 4) whose x axes point along ``yaws`` (n,), dipped by ``pitches`` (n,).

    ``positions`` (n, 3) metres; angles in rad, a pitch that looks down is positive.
    """
    cy, sy, cp, sp = np.cos(yaws), np.sin(yaws), np.cos(pitches), np.sin(pitches)
    T = np.zeros((len(yaws), 4, 4))
    T[:, 0, 0], T[:, 0, 1], T[:, 0, 2] = cy * cp, -sy, cy * sp
    T[:, 1, 0], T[:, 1, 1], T[:, 1, 2] = sy * cp, cy, sy * sp
    T[:, 2, 0], T[:, 2, 2], T[:, 3, 3] = -sp, cp, 1.0
    T[:, :3, 3] = positions
    return T


@lru_cache(maxsize=8)
def _circumscribed(sides: int) -> tuple[float, Array]:
    """A polygon around a circle: its radius per circumradius, and directions (k, 2) to corners."""
    angles = np.arange(sides) * (2.0 * np.pi / sides)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    directions.flags.writeable = False
    return float(np.cos(np.pi / sides)), directions


def footprint_corners(shape: Shape, pose: npt.ArrayLike, sides: int = 32) -> Array:
    """Outline (k, 2) of the upright shape in the world; a cylinder as a circumscribed polygon."""
    values = np.asarray(pose, dtype=np.float64)
    if isinstance(shape, Cylinder):
        shrink, directions = _circumscribed(sides)
        return values[:2] + shape.radius / shrink * directions
    hx, hy = shape.size[0] / 2.0, shape.size[1] / 2.0
    yaw = yaw_of(values)
    c, s = np.cos(yaw), np.sin(yaw)
    corners = np.array([[hx, hy], [-hx, hy], [-hx, -hy], [hx, -hy]])
    return values[:2] + corners @ np.array([[c, s], [-s, c]])


def shape_document(shape: Shape) -> dict[str, Any]:
    """The shape as it stands in files."""
    if isinstance(shape, Box):
        return {"box": [float(v) for v in shape.size]}
    return {"cylinder": {"radius": shape.radius, "height": shape.height}}
