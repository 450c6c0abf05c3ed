"""The scene of a recording for viser, the same in a file and on a server."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from mamo_core.robots.model import ArmModel
from mamo_core.types.recording import Recording
from mamo_core.view.browser.moving import (
    add_arm,
    add_caption,
    add_ghosts,
    add_objects,
    add_violations,
)
from mamo_core.view.browser.still import add_fixtures, add_paths, add_region

if TYPE_CHECKING:
    from viser import SceneApi, ViserServer

_EYE = np.array([-1.15, -0.95, 1.15])
"""From the middle of the workspace to the camera, m: behind the robot's right shoulder, above."""

_LIGHT = _EYE + np.array([0.0, 0.6, 1.2])
"""Where light comes from, seen from the origin."""


def set_stage(server: ViserServer, recording: Recording, robot: ArmModel) -> Callable[[int], None]:
    """Add everything to the server's scene; the function shows a row of the recording."""
    scene = server.scene
    scene.set_up_direction("+z")
    _set_light(scene)
    _set_camera(server, recording)
    add_fixtures(scene, recording.problem)
    add_region(scene, recording)
    add_paths(scene, recording)
    movers = (
        add_arm(scene, recording, robot),
        *add_objects(scene, recording),
        *add_ghosts(scene, recording),
        *add_violations(scene, recording, robot),
        add_caption(scene, recording),
    )

    def show(row: int) -> None:
        for move in movers:
            move(row)

    show(0)
    return show


def _set_light(scene: SceneApi) -> None:
    """Even light and some from behind the camera: what is viser's own washes out the colours."""
    scene.configure_environment_map(None)
    scene.configure_default_lights(enabled=False)
    scene.add_light_ambient("/light/even", intensity=1.5)
    scene.add_light_directional("/light/behind", intensity=2.0, position=_LIGHT, cast_shadow=True)


def _set_camera(server: ViserServer, recording: Recording) -> None:
    space = recording.problem.scene.workspace
    middle = np.array([*(space.lower + space.upper)[:2] / 2.0, space.floor])
    server.initial_camera.look_at = middle
    server.initial_camera.position = middle + _EYE
    server.initial_camera.fov = np.deg2rad(45.0)
