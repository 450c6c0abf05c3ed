"""The gantry as an arm that every engine can load: what it is told to do is what its tool does."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import numpy as np

from mamo_core.robots.library import cache_folder
from mamo_core.robots.model import ArmModel, BodyPart, GripperModel, LinkModel
from mamo_core.robots.urdf import write_urdf
from mamo_core.testing.gantry import GANTRY
from mamo_core.types.geometry import Array

FOOT = 0.04
"""The tool is a foot of this size (m) along x and y, centred on the tool frame, and a stalk."""

FOOT_HEIGHT, STALK, STALK_HEIGHT = 0.02, 0.01, 0.30
_MASS = 0.5
_VERSION = 2

POST = (-1.5, -1.5, 0.8)
"""Centre (m) of the robot's own post, a cube that hangs where nothing else happens."""

POST_SIDE = 0.1


def gantry_arm() -> ArmModel:
    """Joints x, y, z (m) and yaw (rad) of the tool frame, which is under the foot, in the world.

    Only the foot and the thin stalk above it can touch anything, the robot's own post among it.
    """
    folder = cache_folder() / "testing" / f"gantry-{_VERSION}"
    folder.mkdir(parents=True, exist_ok=True)
    foot = _box(folder / "foot.obj", FOOT, FOOT_HEIGHT, 0.0)
    stalk = _box(folder / "stalk.obj", STALK, STALK_HEIGHT, FOOT_HEIGHT)
    post = _box(folder / "post.obj", POST_SIDE, POST_SIDE, POST[2] - POST_SIDE / 2.0, POST[:2])
    axes = np.eye(3)
    links = (
        *(_link("xyz"[k], k - 1, axes[k], True, k, ()) for k in range(3)),
        _link("yaw", 2, axes[2], False, 3, (foot, stalk)),
    )
    arm = ArmModel(
        name=GANTRY,
        joint_names=("x", "y", "z", "yaw"),
        lower=np.array([-3.0, -3.0, -1.0, -np.pi]),
        upper=np.array([3.0, 3.0, 3.0, np.pi]),
        velocity=np.full(4, 2.0),
        acceleration=np.full(4, 20.0),
        jerk=np.full(4, 2000.0),
        effort=np.full(4, 400.0),
        links=links,
        tool_link=3,
        T_link_tool=np.eye(4),
        gripper=GripperModel(np.array([[0.0, 0.0], [0.1, 0.1]]), 0.02, 0.2, 50.0),
        home=np.zeros(4),
        body=(BodyPart("post", (post,), (post,)),),
        urdf=folder / "arm.urdf",
        self_pairs=((3, 4),),
        hull_pairs=((3, 4),),
    )
    if not arm.urdf.exists():
        write_urdf(arm)
    return arm


def _link(
    name: str, parent: int, axis: Array, prismatic: bool, coordinate: int, hulls: tuple[Path, ...]
) -> LinkModel:
    return LinkModel(
        name=name,
        parent=parent,
        T_parent_joint=np.eye(4),
        axis=axis,
        prismatic=prismatic,
        coordinate=coordinate,
        mass=_MASS,
        center_of_mass=np.zeros(3),
        inertia=0.01 * np.eye(3),
        hulls=hulls,
        meshes=hulls,
        spheres=np.zeros((0, 4)),
    )


def _box(
    path: Path,
    size: float,
    height: float,
    bottom: float,
    middle: tuple[float, float] = (0.0, 0.0),
) -> Path:
    """Write an upright box as OBJ, complete or not at all."""
    half = size / 2.0
    corners = [
        (middle[0] + x, middle[1] + y, z)
        for x in (-half, half)
        for y in (-half, half)
        for z in (bottom, bottom + height)
    ]
    faces = ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4")
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {face}" for face in faces]
    handle, work = tempfile.mkstemp(dir=path.parent)
    with os.fdopen(handle, "w") as file:
        file.write("\n".join(lines) + "\n")
    Path(work).replace(path)
    return path
