"""What does not move: fixtures, the space the retrieval sweeps, and intended paths."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mamo_core.types.problem import Problem
from mamo_core.types.recording import Recording
from mamo_core.types.scene import Fixture
from mamo_core.view.solids import region_mesh, shape_mesh
from mamo_core.view.topdown import PATH, REGION, WALL

if TYPE_CHECKING:
    from viser import SceneApi

_SEEN_THROUGH = 0.15
"""Opacity of fixtures that stand beside or above objects."""

_SWEPT = 0.4
"""Opacity of the swept space."""

_RAISED = 0.002
"""Paths are drawn so far above the floor, m."""


def rgb(color: str) -> tuple[int, int, int]:
    """Red, green and blue, 0 to 255, of ``#rrggbb``."""
    red, green, blue = bytes.fromhex(color.removeprefix("#"))
    return red, green, blue


def add_mesh(
    scene: SceneApi, name: str, mesh: Any, color: str, opacity: float | None = None
) -> Any:
    """A node with a ``trimesh.Trimesh`` in one colour; only what is opaque knows shadows."""
    return scene.add_mesh_simple(
        name,
        np.asarray(mesh.vertices),
        np.asarray(mesh.faces),
        color=rgb(color),
        opacity=opacity,
        flat_shading=True,
        cast_shadow=opacity is None,
        receive_shadow=opacity is None,
    )


def add_fixtures(scene: SceneApi, problem: Problem) -> None:
    """What carries objects is opaque, all else lets the view through."""
    for fixture in problem.scene.fixtures:
        carries = _top(fixture) <= problem.scene.workspace.floor + 1e-6
        opacity = None if carries else _SEEN_THROUGH
        name = f"/fixtures/{fixture.name}"
        node = add_mesh(scene, name, shape_mesh(fixture.shape), WALL, opacity)
        node.position, node.wxyz = fixture.pose[:3], fixture.pose[3:]


def _top(fixture: Fixture) -> float:
    return float(fixture.pose[2]) + fixture.shape.height / 2.0


def add_region(scene: SceneApi, recording: Recording) -> None:
    """The swept space up to the tallest object, if the plan has one."""
    region, objects = recording.plan.region, recording.problem.scene.objects
    if region is None:
        return
    poses = recording.problem.initial.object_poses
    tops = [p[2] + item.shape.height / 2.0 for item, p in zip(objects, poses, strict=True)]
    mesh = region_mesh(region, max(tops))
    if mesh is not None:
        add_mesh(scene, "/swept", mesh, REGION, _SWEPT)


def add_paths(scene: SceneApi, recording: Recording) -> None:
    """The path each object should follow, as a line on the floor."""
    height = recording.problem.scene.workspace.floor + _RAISED
    for number, action in enumerate(recording.plan.actions, 1):
        points = np.column_stack([action.path, np.full(len(action.path), height)])
        if len(points) < 2:
            continue
        pieces = np.stack([points[:-1], points[1:]], axis=1)
        name = f"/paths/{number} {action.object_name}"
        scene.add_line_segments(name, pieces, colors=rgb(PATH), thickness=0.008)
