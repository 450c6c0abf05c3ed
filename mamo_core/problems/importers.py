"""From the thesis' scenes to problems."""

from __future__ import annotations

import numpy as np

from mamo_core.problems.grasps import default_grasps
from mamo_core.problems.thesis import Board, Body, ThesisScene
from mamo_core.robots.grasps import hand_of
from mamo_core.types.geometry import Box, Cylinder, Shape, make_pose
from mamo_core.types.problem import Problem
from mamo_core.types.scene import (
    MINIMUM_MASS,
    Fixture,
    Mobility,
    Scene,
    SceneObject,
    SceneState,
    Workspace,
)

ROBOT = "pr2_right_arm"

HOME = (-1.68651, -0.184315, -1.67611, -1.66215, 0.285096, -0.658798, 1.41563)
"""The author's start and goal configuration of the right arm, rad."""

INTERIOR_LOWER = (0.48, -0.90, 0.77)
INTERIOR_UPPER = (1.08, -0.10, 1.09)
"""Inside of the shelf, m; the side at x = 0.48 is open."""

OVERHANG = 0.05
"""Objects reach up to 4.7 cm past the open side, m."""


def thesis_workspace() -> Workspace:
    """The inside of the thesis' shelf."""
    return Workspace(np.array(INTERIOR_LOWER), np.array(INTERIOR_UPPER), OVERHANG)


def problem_from_thesis(record: ThesisScene) -> tuple[Problem, list[str]]:
    """The problem of a published scene, and in words what had to be changed.

    Objects are named ``o<id>``. Fixture friction is 1.0: the coefficient of a pair is the product
    and that of object and fixture the object's own. Masses below MINIMUM_MASS are raised to it.
    The first grasps approach along the author's pre-grasp yaw.
    """
    kinds = [(record.ooi, Mobility.TARGET)]
    kinds += [(body, Mobility.IMMOVABLE) for body in record.immovables]
    kinds += [(body, Mobility.MOVABLE) for body in record.movables]
    kinds.sort(key=lambda kind: kind[0].id)
    objects = tuple(_object(body, mobility) for body, mobility in kinds)
    poses = np.array([make_pose(body.pos, body.yaw) for body, _ in kinds])
    scene = Scene(
        robot=ROBOT,
        T_world_base=make_pose([0.0, 0.0, 0.0]),
        fixtures=tuple(_fixture(board) for board in record.shelf),
        objects=objects,
        workspace=thesis_workspace(),
    )
    home = np.array(HOME)
    problem = Problem(
        name=f"thesis_{record.id}",
        scene=scene,
        initial=SceneState(home, poses),
        home=home,
        grasps=default_grasps(
            objects[scene.target_index],
            hand_of(ROBOT),
            first_yaw=record.pregrasp.yaw - record.ooi.yaw,
        ),
    )
    return problem, [_clamped(record, body) for body, _ in kinds if body.mass < MINIMUM_MASS]


def _object(body: Body, mobility: Mobility) -> SceneObject:
    mass = max(body.mass, MINIMUM_MASS)
    return SceneObject(_name(body), _shape(body), mobility, mass, body.mu)


def _name(body: Body) -> str:
    return f"o{body.id}"


def _shape(body: Body) -> Shape:
    if body.shape == "box":
        if body.size is None:
            raise ValueError(f"object {_name(body)!r}: a box needs 'size'")
        return Box(np.array(body.size))
    if body.radius is None or body.height is None:
        raise ValueError(f"object {_name(body)!r}: a cylinder needs 'radius' and 'height'")
    return Cylinder(body.radius, body.height)


def _fixture(board: Board) -> Fixture:
    return Fixture(board.name, Box(np.array(board.size)), make_pose(board.pos), friction=1.0)


def _clamped(record: ThesisScene, body: Body) -> str:
    return (
        f"thesis_{record.id}: object {_name(body)!r} weighs {1000 * body.mass:.3g} g; "
        f"raised to {1000 * MINIMUM_MASS:.0f} g"
    )
