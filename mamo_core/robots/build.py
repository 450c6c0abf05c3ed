"""Cuts a canonical arm out of a published URDF: pinocchio reduces, trimesh gives hulls."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mamo_core.robots.body import body_parts, with_self_collision
from mamo_core.robots.model import ArmModel, GripperModel, LinkModel
from mamo_core.robots.specs import ArmSpec, robot_data_folder
from mamo_core.robots.spheres import cover_hull
from mamo_core.robots.urdf import write_urdf
from mamo_core.types.geometry import Array

CONTINUOUS_RANGE = 4.0 * np.pi
"""Continuous joints become revolute within plus or minus this, rad; every engine reads that."""


@dataclass(frozen=True, eq=False)
class _JointData:
    axis: Array
    prismatic: bool
    lower: float
    upper: float
    velocity: float
    effort: float


def build_arm(spec: ArmSpec, folder: Path) -> ArmModel:
    """Make the arm and write its hulls, meshes and URDF into ``folder``."""
    import pinocchio as pin

    urdf = robot_data_folder() / spec.urdf
    model, geometry = _reduced(pin, spec, urdf)
    joints = _joint_data(urdf)
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    pieces = _pieces(model, geometry)
    links = tuple(
        _link(pin, spec, model, joints, number, pieces, folder)
        for number in range(1, model.njoints)
    )
    tool_frame = model.frames[model.getFrameId(spec.tool_link)]
    arm_joints = [joints[name] for name in spec.joints]
    arm = ArmModel(
        name=spec.name,
        joint_names=spec.joints,
        lower=np.array([j.lower for j in arm_joints]),
        upper=np.array([j.upper for j in arm_joints]),
        velocity=np.array([j.velocity for j in arm_joints]),
        acceleration=np.array(spec.acceleration),
        jerk=np.array(spec.jerk),
        effort=np.array([j.effort for j in arm_joints]),
        links=links,
        tool_link=int(tool_frame.parentJoint) - 1,
        T_link_tool=tool_frame.placement.homogeneous @ spec.T_link_tool,
        gripper=_gripper(spec, links, tool_frame, pieces),
        home=np.array(spec.home),
        body=body_parts(_standing_pieces(model, geometry), folder),
        urdf=folder / "arm.urdf",
    )
    write_urdf(arm)
    return with_self_collision(arm, _mount(urdf, spec.joints[0]))


def _reduced(pin: Any, spec: ArmSpec, urdf: Path) -> tuple[Any, Any]:
    full = pin.buildModelFromUrdf(str(urdf))
    packages = [str(robot_data_folder().parents[1])]
    geometry = pin.buildGeomFromUrdf(full, str(urdf), pin.GeometryType.COLLISION, None, packages)
    reference = pin.neutral(full)
    for name, value in spec.locked.items():
        joint = full.joints[full.getJointId(name)]
        # The position of a joint without end is a cosine and a sine.
        reference[joint.idx_q : joint.idx_q + joint.nq] = (
            value if joint.nq == 1 else (np.cos(value), np.sin(value))
        )
    keep = {*spec.joints, *spec.finger_joints}
    locked = [i for i in range(1, full.njoints) if full.names[i] not in keep]
    return pin.buildReducedModel(full, geometry, locked, reference)


def _joint_data(urdf: Path) -> dict[str, _JointData]:
    found = {}
    for joint in ElementTree.parse(urdf).getroot().iter("joint"):
        kind = joint.get("type")
        if kind not in ("revolute", "continuous", "prismatic"):
            continue
        axis = joint.find("axis")
        words = axis.get("xyz", "1 0 0") if axis is not None else "1 0 0"
        limit = joint.find("limit")
        numbers = dict(limit.attrib) if limit is not None else {}
        wide = kind == "continuous"
        found[str(joint.get("name"))] = _JointData(
            axis=np.array([float(v) for v in words.split()]),
            prismatic=kind == "prismatic",
            lower=-CONTINUOUS_RANGE if wide else float(numbers.get("lower", 0.0)),
            upper=CONTINUOUS_RANGE if wide else float(numbers.get("upper", 0.0)),
            velocity=float(numbers.get("velocity", 1.0)),
            effort=float(numbers.get("effort", 100.0)),
        )
    return found


def _pieces(model: Any, geometry: Any) -> dict[int, list[Any]]:
    """Collision meshes (trimesh, joint frame) by joint number; 0 is the fixed base."""
    pieces: dict[int, list[Any]] = {}
    for item in geometry.geometryObjects:
        mesh = _trimesh_of(item)
        mesh.apply_transform(item.placement.homogeneous)
        pieces.setdefault(int(item.parentJoint), []).append(mesh)
    return pieces


def _trimesh_of(item: Any) -> Any:
    import trimesh

    if item.meshPath and Path(item.meshPath).suffix:
        mesh = trimesh.load(item.meshPath, force="mesh")
        mesh.apply_scale(np.asarray(item.meshScale).ravel())
        return mesh
    half = getattr(item.geometry, "halfSide", None)
    if half is None:
        raise ValueError(f"robot geometry {item.name}: only meshes and boxes are understood")
    return trimesh.creation.box(2.0 * np.asarray(half))


def _link(
    pin: Any,
    spec: ArmSpec,
    model: Any,
    joints: dict[str, _JointData],
    number: int,
    pieces: dict[int, list[Any]],
    folder: Path,
) -> LinkModel:
    name = model.names[number]
    finger = name in spec.finger_joints
    slack = spec.finger_slack if finger else spec.cover_slack[name]
    hulls, meshes, spheres = [], [], [np.zeros((0, 4))]
    for k, piece in enumerate(pieces.get(number, [])):
        hull = piece.convex_hull
        hulls.append(folder / f"{name}_{k}.obj")
        meshes.append(folder / f"{name}_{k}.stl")
        hull.export(hulls[-1], digits=9)
        piece.export(meshes[-1])
        spheres.append(cover_hull(hull, slack))
    inertia = model.inertias[number]
    return LinkModel(
        name=name,
        parent=int(model.parents[number]) - 1,
        T_parent_joint=model.jointPlacements[number].homogeneous,
        axis=joints[name].axis,
        prismatic=joints[name].prismatic,
        coordinate=-1 if finger else spec.joints.index(name),
        mass=float(inertia.mass),
        center_of_mass=np.array(inertia.lever),
        inertia=np.array(inertia.inertia),
        hulls=tuple(hulls),
        meshes=tuple(meshes),
        spheres=np.vstack(spheres),
    )


def _gripper(
    spec: ArmSpec, links: tuple[LinkModel, ...], tool_frame: Any, pieces: dict[int, list[Any]]
) -> GripperModel:
    """Measures the gap between the finger meshes over the travel of the finger joints."""
    from mamo_core.robots.kinematics import finger_transforms

    T_link_tool = tool_frame.placement.homogeneous @ spec.T_link_tool
    rows = []
    for drive in np.linspace(0.0, spec.finger_travel, 33):
        gap = np.inf
        for number, T_link_finger in finger_transforms(links, drive).items():
            T_tool_finger = np.linalg.inv(T_link_tool) @ T_link_finger
            for mesh in pieces.get(number + 1, []):
                # The engines see hulls, which fill the hollow inner sides of fingers.
                hull = mesh.convex_hull.copy().apply_transform(T_tool_finger)
                side = np.abs(_ahead_of(hull, -spec.finger_zone)[:, 1])
                gap = min(gap, 2.0 * float(side.min(initial=np.inf)))
        rows.append((gap, drive))
    table = np.array(rows)
    rising = np.concatenate([[True], np.diff(np.maximum.accumulate(table[:, 0])) > 1e-6])
    return GripperModel(
        drive_of_opening=table[rising],
        depth=spec.finger_zone,
        speed=spec.gripper_speed,
        force=spec.gripper_force,
    )


def _ahead_of(hull: Any, x: float) -> Array:
    """Corners (k, 3) of the part of a convex mesh beyond the plane at ``x``."""
    a, b = hull.vertices[hull.edges_unique].transpose(1, 0, 2)
    crossing = (a[:, 0] - x) * (b[:, 0] - x) < 0.0
    a, b = a[crossing], b[crossing]
    cut = a + (b - a) * ((x - a[:, 0]) / (b[:, 0] - a[:, 0]))[:, None]
    return np.vstack([hull.vertices[hull.vertices[:, 0] >= x], cut])


def _standing_pieces(model: Any, geometry: Any) -> dict[str, list[Any]]:
    """Collision meshes of what never moves (trimesh, base frame), by link of the URDF."""
    pieces: dict[str, list[Any]] = {}
    for item in geometry.geometryObjects:
        if item.parentJoint == 0:
            mesh = _trimesh_of(item)
            mesh.apply_transform(item.placement.homogeneous)
            pieces.setdefault(model.frames[item.parentFrame].name, []).append(mesh)
    return pieces


def _mount(urdf: Path, joint_name: str) -> str:
    """The link that a joint begins at."""
    for joint in ElementTree.parse(urdf).getroot().iter("joint"):
        parent = joint.find("parent")
        if joint.get("name") == joint_name and parent is not None:
            return parent.get("link", "")
    raise ValueError(f"{urdf}: no joint {joint_name!r}")
