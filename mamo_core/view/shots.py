"""Where the camera stands: over the robot's shoulder, all of the workspace in the picture."""

from __future__ import annotations

from itertools import product

import numpy as np

from mamo_core.interfaces.renderer import Shot
from mamo_core.types.geometry import Array, Box, invert, matrix_from_pose
from mamo_core.types.problem import Problem
from mamo_core.types.scene import Fixture, Workspace
from mamo_core.view.topdown import COLORS

BROKEN = "#c2001a"
"""Of an object that broke a constraint."""

_FROM_TARGET = np.array([-0.85, 0.42, 0.90])
"""Direction from the middle of the workspace to the camera, which stands to the robot's left."""
_HAND_ROOM = 0.30
"""Shown before the open side, where the arm comes in, m."""
_VIEW_ANGLE = float(np.radians(38.0))
_BORDER = 1.04
_HIDDEN = 0.05
"""Of boxes that hide more than this part of the floor of the workspace only the edges are drawn."""


def shot_of(problem: Problem, width: int, height: int) -> Shot:
    """A picture of ``width`` x ``height`` pixels of what happens in the workspace."""
    space = problem.scene.workspace
    lower, upper = _shown(problem)
    target = (lower + upper) / 2.0
    eye = _far_enough(lower, upper, target, width / height)
    return Shot(
        eye=eye,
        target=target,
        view_angle=_VIEW_ANGLE,
        width=width,
        height=height,
        colors=COLORS,
        broken=BROKEN,
        outlined=frozenset(f.name for f in problem.scene.fixtures if _hides(f, eye, space)),
    )


def _shown(problem: Problem) -> tuple[Array, Array]:
    """Lower and upper corner of what must be in the picture: the workspace and room for the hand.

    Of a workspace without walls only what stands in it.
    """
    scene = problem.scene
    tops = [
        pose[2] + item.shape.height / 2.0
        for item, pose in zip(scene.objects, problem.initial.object_poses, strict=True)
    ]
    tops += [fixture.pose[2] + fixture.shape.height / 2.0 for fixture in scene.fixtures]
    upper = np.minimum(scene.workspace.upper, [np.inf, np.inf, max(tops)])
    return scene.workspace.lower - np.array([_HAND_ROOM, 0.0, 0.0]), upper


def _far_enough(lower: Array, upper: Array, target: Array, aspect: float) -> Array:
    """The nearest camera on the line from the target that sees every corner."""
    back = _FROM_TARGET / np.linalg.norm(_FROM_TARGET)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    corners = np.array(list(product(*zip(lower, upper, strict=True)))) - target
    slope = np.tan(_VIEW_ANGLE / 2.0)
    across = np.abs(corners @ right) / (slope * aspect)
    along = np.abs(corners @ up) / slope
    distance = float((corners @ back + _BORDER * np.maximum(across, along)).max())
    return target + distance * back


def _hides(fixture: Fixture, eye: Array, space: Workspace) -> bool:
    """Whether it stands between the camera and the floor of the workspace."""
    if not isinstance(fixture.shape, Box):
        return False
    x, y = (np.linspace(space.lower[i], space.upper[i], 12)[1:-1] for i in (0, 1))
    floor = np.array([[*xy, space.floor + 0.01] for xy in product(x, y)])
    into = invert(matrix_from_pose(fixture.pose))
    start = into[:3, :3] @ eye + into[:3, 3]
    rays = floor @ into[:3, :3].T + into[:3, 3] - start
    faces = np.array([-0.5, 0.5])[:, None, None] * fixture.shape.size
    with np.errstate(divide="ignore"):
        sides = np.sort((faces - start) / rays, axis=0)
    enters, leaves = sides[0].max(axis=1), sides[1].min(axis=1)
    return bool(((enters < leaves) & (leaves > 0.0) & (enters < 1.0)).mean() > _HIDDEN)
