"""What moves or changes: the arm, objects, what went wrong, and what is being done.

Functions add nodes and give functions that show a row of the recording.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from mamo_core.robots.kinematics import joint_transform, tool_transform
from mamo_core.robots.model import ArmModel, LinkModel
from mamo_core.types.geometry import Array, matrix_from_pose, pose_from_matrix
from mamo_core.types.recording import Recording
from mamo_core.types.rollout import Violation
from mamo_core.view.browser.still import add_mesh, rgb
from mamo_core.view.differences import SHOWN, differences
from mamo_core.view.engines import engine_colors
from mamo_core.view.solids import part_mesh, shape_mesh
from mamo_core.view.topdown import COLORS

if TYPE_CHECKING:
    from viser import SceneApi

Mover = Callable[[int], None]

ARM, BODY = "#c3c8ce", "#a2a8ae"
WRONG = "#b000d8"
_GHOST = 0.5
_NAME_SIZE, _TEXT_SIZE = 0.75, 0.9
_CAPTION = 0.42
"""Height above the floor, m."""

_MARK = 0.012
"""Radius of what marks a violation, m."""


def add_arm(scene: SceneApi, recording: Recording, robot: ArmModel) -> Mover:
    """The robot as the first engine moved it; links are nodes below those that carry them."""
    T_world_base = recording.problem.scene.T_world_base
    place = {"position": T_world_base[:3], "wxyz": T_world_base[3:]}
    scene.add_frame("/robot", show_axes=False, **place)
    _add_body(scene, robot)
    names: list[str] = []
    for link in robot.links:
        names.append(f"{names[link.parent] if link.parent >= 0 else '/robot'}/{link.name}")
    nodes = [_add_link(scene, *pair) for pair in zip(names, robot.links, strict=True)]
    first = recording.executions[0]

    def show(row: int) -> None:
        drive = robot.gripper.drive(float(first.openings[row]))
        for node, link in zip(nodes, robot.links, strict=True):
            moved = drive if link.coordinate < 0 else float(first.joints[row, link.coordinate])
            _put(node, pose_from_matrix(link.T_parent_joint @ joint_transform(link, moved)))

    return show


def _add_body(scene: SceneApi, robot: ArmModel) -> None:
    for part in robot.body:
        mesh = part_mesh(part)
        if mesh is not None:
            add_mesh(scene, f"/robot/{part.name}", mesh, BODY)


def _add_link(scene: SceneApi, name: str, link: LinkModel) -> Any:
    mesh = part_mesh(link)
    if mesh is None:
        return scene.add_frame(name, show_axes=False)
    return add_mesh(scene, name, mesh, ARM)


def add_objects(scene: SceneApi, recording: Recording) -> Iterator[Mover]:
    """Objects by role, with their names, as the first engine moved them."""
    for i, item in enumerate(recording.problem.scene.objects):
        node = add_mesh(
            scene, f"/objects/{item.name}", shape_mesh(item.shape), COLORS[item.mobility]
        )
        scene.add_label(
            f"/objects/{item.name}/name",
            item.name,
            position=(0.0, 0.0, item.shape.height / 2.0),
            font_screen_scale=_NAME_SIZE,
            anchor="bottom-center",
        )
        yield _follow(node, recording.executions[0].poses[:, i])


def add_ghosts(scene: SceneApi, recording: Recording) -> Iterator[Mover]:
    """Objects where the other engines have them, while that is elsewhere."""
    colors, apart = engine_colors(recording), differences(recording)
    for other in recording.executions[1:]:
        for name, distances in apart[other.engine].items():
            i = recording.problem.scene.index(name)
            mesh = shape_mesh(recording.problem.scene.objects[i].shape)
            node_name, color = f"/ghosts/{other.engine}/{name}", colors[other.engine]
            node = add_mesh(scene, node_name, mesh, color, _GHOST)
            yield _follow(node, other.poses[:, i])
            yield _appear(node, distances > SHOWN)


def add_violations(scene: SceneApi, recording: Recording, robot: ArmModel) -> Iterator[Mover]:
    """A mark with words where each violation happened, from its time on."""
    several = len(recording.executions) > 1
    for execution in recording.executions:
        for number, violation in enumerate(execution.violations):
            row = row_at(recording, violation.time)
            involved = _involved(recording, violation)
            if involved is None:
                place = _hand(recording, robot, execution.joints[row])
            else:
                place = _above(recording, involved, execution.poses[row, involved])
            name = f"/violations/{execution.engine} {number}"
            node = scene.add_icosphere(name, _MARK, color=rgb(WRONG), position=place)
            text = f"{execution.engine}: {violation}" if several else str(violation)
            style = {"font_screen_scale": _TEXT_SIZE, "anchor": "bottom-center"}
            scene.add_label(f"{name}/text", text, position=(0.0, 0.0, 2.0 * _MARK), **style)
            yield _appear(node, np.arange(len(recording.times)) >= row)


def row_at(recording: Recording, seconds: float) -> int:
    """The row nearest to a time."""
    return int(np.abs(recording.times - seconds).argmin())


def _involved(recording: Recording, violation: Violation) -> int | None:
    """Place of the first of the two that is an object; None if the robot hit a fixture."""
    names = (violation.subject, violation.other)
    objects = enumerate(recording.problem.scene.objects)
    return next((i for i, item in objects if item.name in names), None)


def _above(recording: Recording, place: int, pose: Array) -> Array:
    half = recording.problem.scene.objects[place].shape.height / 2.0
    x, y, z = pose[:3]
    return np.array([x, y, z + half + 2.0 * _MARK])


def _hand(recording: Recording, robot: ArmModel, joints: Array) -> Array:
    T_world_base = matrix_from_pose(recording.problem.scene.T_world_base)
    return np.array((T_world_base @ tool_transform(robot, joints))[:3, 3])


def add_caption(scene: SceneApi, recording: Recording) -> Mover:
    """What the arm is doing, behind the workspace and above most objects."""
    space = recording.problem.scene.workspace
    place = np.array(
        [space.upper[0], (space.lower[1] + space.upper[1]) / 2.0, space.floor + _CAPTION]
    )
    label = scene.add_label(
        "/caption", "", position=place, font_screen_scale=1.4, anchor="bottom-center"
    )
    texts = captions(recording)

    def show(row: int) -> None:
        label.text = texts[row]

    return show


def captions(recording: Recording) -> list[str]:
    """The motion and what its segment is for, by row."""
    return [
        f"{recording.title(stretch.motion)}: {stretch.kind}"
        for stretch in recording.stretches
        for _ in range(stretch.first, stretch.last + 1)
    ]


def _follow(node: Any, poses: Array) -> Mover:
    return lambda row: _put(node, poses[row])


def _appear(node: Any, shown: Any) -> Mover:
    def show(row: int) -> None:
        node.visible = bool(shown[row])

    return show


def _put(node: Any, pose: Array) -> None:
    node.position, node.wxyz = pose[:3], pose[3:]
