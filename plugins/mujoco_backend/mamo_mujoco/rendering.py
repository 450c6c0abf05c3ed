"""Draws recordings with MuJoCo's renderer."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations, product
from typing import Any

import mujoco
import numpy as np

from mamo_core.interfaces.renderer import Image, Renderer, Shot
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, Box, IntArray, matrix_from_pose
from mamo_core.types.recording import RecordedExecution, Recording
from mamo_core.types.scene import Mobility
from mamo_mujoco.canvas import open_canvas
from mamo_mujoco.scenery import FIXTURE, build_scenery, geom_name, joint_name, rgba

_ROOM = 1000
"""Geoms that a scene may hold beside those of the model: edges and lamps."""
_LINE = 2.0
"""Width of an edge, pixels."""


class MuJoCoRenderer(Renderer):
    """Sets robot and objects where the recording has them; nothing is simulated."""

    def __init__(self, arm: ArmModel) -> None:
        self._arm = arm

    def frames(self, recording: Recording, rows: Iterable[int], shot: Shot) -> Iterator[Image]:
        model = build_scenery(recording, self._arm, shot)
        data, scene = mujoco.MjData(model), mujoco.MjvScene(model, maxgeom=model.ngeom + _ROOM)
        camera, option = _camera(shot), mujoco.MjvOption()
        drawn = mujoco.mjtCatBit.mjCAT_ALL.value
        joints, edges = self._joint_addresses(model), _edges(recording, shot)
        with open_canvas(model, shot.width, shot.height) as canvas:
            for row in rows:
                self._pose(data, joints, recording, row)
                _color(model, recording, row, shot)
                mujoco.mj_kinematics(model, data)
                mujoco.mj_camlight(model, data)
                mujoco.mjv_updateScene(model, data, option, None, camera, drawn, scene)
                _add_lines(scene, edges)
                yield canvas.draw(scene)

    def _joint_addresses(self, model: Any) -> IntArray:
        names = [joint_name(link) for link in self._arm.links]
        return np.array([model.jnt_qposadr[model.joint(name).id] for name in names])

    def _pose(self, data: Any, joints: IntArray, recording: Recording, row: int) -> None:
        """Everything as the recording has it in that row."""
        first = recording.executions[0]
        drive = self._arm.gripper.drive(float(first.openings[row]))
        data.qpos[joints] = [
            drive if link.coordinate < 0 else first.joints[row, link.coordinate]
            for link in self._arm.links
        ]
        poses = np.concatenate([execution.poses[row] for execution in recording.executions])
        data.mocap_pos[:], data.mocap_quat[:] = poses[:, :3], poses[:, 3:]


def _color(model: Any, recording: Recording, row: int, shot: Shot) -> None:
    """Objects that have broken a constraint by then."""
    time = float(recording.times[row])
    for engine, execution in enumerate(recording.executions):
        broken = _broken(execution, time)
        for item in recording.problem.scene.objects:
            if engine and item.mobility is Mobility.IMMOVABLE:
                continue  # drawn once
            geom = model.geom(geom_name(engine, item.name))
            color = shot.broken if item.name in broken else shot.colors[item.mobility]
            geom.rgba = rgba(color, geom.rgba[3])


def _broken(execution: RecordedExecution, time: float) -> set[str | None]:
    past = execution.broken_by(time)
    return {name for violation in past for name in (violation.subject, violation.other)}


def _edges(recording: Recording, shot: Shot) -> list[tuple[Array, Array]]:
    """Both ends (3,) of every edge of the boxes that are only outlined."""
    corners = np.array(list(product((-0.5, 0.5), repeat=3)))
    pairs = [(i, j) for i, j in combinations(range(8), 2) if (corners[i] != corners[j]).sum() == 1]
    found = []
    for fixture in recording.problem.scene.fixtures:
        if fixture.name in shot.outlined and isinstance(fixture.shape, Box):
            T = matrix_from_pose(fixture.pose)
            ends = (corners * fixture.shape.size) @ T[:3, :3].T + T[:3, 3]
            found += [(ends[i], ends[j]) for i, j in pairs]
    return found


def _add_lines(scene: Any, edges: Sequence[tuple[Array, Array]]) -> None:
    """Add them to what is drawn; unlike geoms of the model they cast no shadow."""
    for start, end in edges:
        geom = scene.geoms[scene.ngeom]
        line = mujoco.mjtGeom.mjGEOM_LINE
        color = rgba(FIXTURE).astype(np.float32)
        mujoco.mjv_initGeom(geom, line, np.zeros(3), np.zeros(3), np.zeros(9), color)
        mujoco.mjv_connector(geom, line, _LINE, start, end)
        scene.ngeom += 1


def _camera(shot: Shot) -> Any:
    """A free camera, which MuJoCo describes by the direction of its view."""
    along = shot.target - shot.eye
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat = shot.target
    camera.distance = float(np.linalg.norm(along))
    camera.azimuth = float(np.degrees(np.arctan2(along[1], along[0])))
    camera.elevation = float(np.degrees(np.arctan2(along[2], np.hypot(along[0], along[1]))))
    return camera
