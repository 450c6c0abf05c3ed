"""The MuJoCo scene of a recording for looking at: exact surfaces, and nothing that moves itself."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from mamo_core.interfaces.renderer import Shot
from mamo_core.robots.model import ArmModel, LinkModel
from mamo_core.types.geometry import Array, Box, Shape, matrix_from_pose, pose_from_matrix
from mamo_core.types.problem import Problem
from mamo_core.types.recording import Recording
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility, Workspace

_ARM, _HAND, _BODY = "#e4e4e4", "#4d5258", "#b9bec4"
FIXTURE = "#d3bd9c"
_FLOOR, _REGION = "#d5d9dd", "#8b8f96"
_GHOST = 0.35
_GHOST_SIZE = 0.98
"""Where engines agree, the ghost is hidden inside the object."""
_THIN = 0.001
"""Half the height of what lies flat on the floor, m."""
_SHADOWED = 1.8
"""How far from the middle of the workspace there are shadows, m."""
_SAMPLES, _SHADOW = 4, 2.0
"""Samples a pixel, and size of the map of shadows relative to the height of the picture: without a
GPU these cost most of the time."""


def build_scenery(recording: Recording, arm: ArmModel, shot: Shot) -> Any:
    """Compile an ``MjModel`` of the robot, the fixtures, and the objects of every engine.

    Every object is a mocap body: those of engine k have the numbers k n to (k + 1) n - 1.
    """
    problem = recording.problem
    spec = mujoco.MjSpec()
    _add_light(spec, problem, shot)
    _add_robot(spec, problem, arm)
    for fixture in problem.scene.fixtures:
        if fixture.name not in shot.outlined:
            body = spec.worldbody.add_body(**_frame(matrix_from_pose(fixture.pose)))
            _add_shape(body, fixture.shape, rgba(FIXTURE))
    if recording.plan.region is not None:
        _add_region(spec, recording.plan.region, problem.scene.workspace)
    for engine in range(len(recording.executions)):
        _add_objects(spec, problem, shot, engine)
    return spec.compile()


def geom_name(engine: int, item: str) -> str:
    """The geom of an object as an engine has it."""
    return f"object:{engine}:{item}"


def joint_name(link: LinkModel) -> str:
    """The joint of a link of the arm."""
    return f"joint:{link.name}"


def rgba(color: str, alpha: float = 1.0) -> Array:
    """The numbers (4,) of ``#rrggbb``."""
    parts = [int(color[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
    return np.array([*parts, alpha])


def _add_light(spec: Any, problem: Problem, shot: Shot) -> None:
    """A bright room, and a lamp above the open side that casts the shadows."""
    space = problem.scene.workspace
    middle = (space.lower + space.upper) / 2.0
    lamp = middle + np.array([-1.2, 0.8, 2.4])
    look = spec.visual
    look.global_.offwidth, look.global_.offheight = shot.width, shot.height
    look.global_.fovy = float(np.degrees(shot.view_angle))
    look.quality.offsamples = _SAMPLES
    look.quality.shadowsize = round(_SHADOW * shot.height)
    look.headlight.ambient = [0.42, 0.42, 0.42]
    look.headlight.diffuse = [0.28, 0.28, 0.28]
    look.headlight.specular = [0.0, 0.0, 0.0]
    look.map.znear, look.map.zfar, look.map.shadowclip = 0.02, 20.0, _SHADOWED
    spec.stat.extent, spec.stat.center = 1.0, middle
    spec.worldbody.add_light(
        pos=lamp,
        dir=(middle - lamp) / np.linalg.norm(middle - lamp),
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        castshadow=True,
        diffuse=[0.5, 0.5, 0.48],
        specular=[0.15, 0.15, 0.15],
    )
    _add_geom(spec.worldbody, mujoco.mjtGeom.mjGEOM_PLANE, [20.0, 20.0, 1.0], rgba(_FLOOR))


def _add_robot(spec: Any, problem: Problem, arm: ArmModel) -> None:
    base = spec.worldbody.add_body(**_frame(matrix_from_pose(problem.scene.T_world_base)))
    for part in arm.body:
        _add_surfaces(spec, base, part.meshes, rgba(_BODY))
    bodies: list[Any] = []
    for number, link in enumerate(arm.links):
        parent = base if link.parent < 0 else bodies[link.parent]
        is_hand = number == arm.tool_link or link.coordinate < 0
        bodies.append(_add_link(spec, parent, link, rgba(_HAND if is_hand else _ARM)))


def _add_link(spec: Any, parent: Any, link: LinkModel, color: Array) -> Any:
    # A joint wants a mass; nothing is ever simulated here.
    body = parent.add_body(
        explicitinertial=True,
        mass=1.0,
        ipos=[0.0, 0.0, 0.0],
        iquat=[1.0, 0.0, 0.0, 0.0],
        inertia=[1.0, 1.0, 1.0],
        **_frame(link.T_parent_joint),
    )
    kind = mujoco.mjtJoint.mjJNT_SLIDE if link.prismatic else mujoco.mjtJoint.mjJNT_HINGE
    body.add_joint(name=joint_name(link), type=kind, axis=link.axis)
    _add_surfaces(spec, body, link.meshes, color)
    return body


def _add_surfaces(spec: Any, body: Any, meshes: Sequence[Path], color: Array) -> None:
    for mesh in meshes:
        # Surfaces with holes have no volume.
        spec.add_mesh(
            name=mesh.stem, file=str(mesh), inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        )
        geom = _add_geom(body, mujoco.mjtGeom.mjGEOM_MESH, None, color)
        geom.meshname = mesh.stem


def _add_objects(spec: Any, problem: Problem, shot: Shot, engine: int) -> None:
    for item in problem.scene.objects:
        body = spec.worldbody.add_body(mocap=True)
        if engine > 0 and item.mobility is Mobility.IMMOVABLE:
            continue
        color = rgba(shot.colors[item.mobility], _GHOST if engine else 1.0)
        geom = _add_shape(body, item.shape, color, _GHOST_SIZE if engine else 1.0)
        geom.name = geom_name(engine, item.name)


def _add_region(spec: Any, region: SweptRegion, space: Workspace) -> None:
    """What the retrieval sweeps, dark on the floor: a strip for each run of cells."""
    swept, cell = region.swept_under(float(space.upper[2])), region.resolution
    for row in range(swept.shape[0]):
        for first, last in _runs(swept[row]):
            lower = np.maximum(region.origin + cell * np.array([row, first]), space.lower[:2])
            upper = np.minimum(region.origin + cell * np.array([row + 1, last]), space.upper[:2])
            if (lower < upper).all():
                size = [*(upper - lower) / 2.0, _THIN]
                geom = _add_geom(spec.worldbody, mujoco.mjtGeom.mjGEOM_BOX, size, rgba(_REGION))
                geom.pos = [*(lower + upper) / 2.0, region.floor]


def _runs(cells: Any) -> Sequence[tuple[int, int]]:
    """Where the true cells begin and end."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], cells, [0]])))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _add_shape(body: Any, shape: Shape, color: Array, scale: float = 1.0) -> Any:
    if isinstance(shape, Box):
        return _add_geom(body, mujoco.mjtGeom.mjGEOM_BOX, scale * shape.size / 2.0, color)
    size = scale * np.array([shape.radius, shape.height / 2.0, 0.0])
    return _add_geom(body, mujoco.mjtGeom.mjGEOM_CYLINDER, size, color)


def _add_geom(body: Any, kind: Any, size: Any, color: Array) -> Any:
    geom = body.add_geom(type=kind, rgba=color, contype=0, conaffinity=0, mass=0.0)
    if size is not None:
        geom.size = size
    return geom


def _frame(T: Array) -> dict[str, Array]:
    pose = pose_from_matrix(T)
    return {"pos": pose[:3], "quat": pose[3:]}
