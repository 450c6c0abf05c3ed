"""Scripted motions whose outcome is known, for the PR2 and for the gantry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mamo_core.constraints.options import BoundsOptions, SpeedOptions, TiltOptions
from mamo_core.constraints.standard import (
    BoundsConstraint,
    ContactConstraint,
    SpeedConstraint,
    TiltConstraint,
)
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.problems.importers import thesis_workspace
from mamo_core.testing.gantry import GANTRY
from mamo_core.types.geometry import Array, Box, Cylinder, make_pose
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.problem import Problem
from mamo_core.types.scene import Fixture, Mobility, Scene, SceneObject, SceneState

SPEED = 0.1
"""Speed of the scripted pushes, m/s."""


@dataclass(frozen=True, eq=False)
class TransitionCases:
    """A problem and motions in it whose outcome is known.

    ``still``: the arm stays where it is, one segment. ``push``: moves the object ``pushed`` by 2
    to 15 cm, in (x, y) direction ``direction``, and nothing else; a sweep and a retract.
    ``crash``: the same, further, so that ``pushed`` grazes the immovable ``hit`` and somewhat later
    another one: two violations at different times, and the arm still arrives.
    """

    problem: Problem
    still: Motion
    push: Motion
    crash: Motion
    pushed: str
    hit: str
    direction: tuple[float, float] = (1.0, 0.0)


_PR2_PATH = (
    (-1.1226, -0.39814, -2.10068, -1.96283, 2.72336, -0.87042, -0.71233),
    (-1.08209, -0.38665, -2.10478, -1.88779, 2.72881, -0.83357, -0.70167),
    (-1.04183, -0.37332, -2.10897, -1.80975, 2.73147, -0.79446, -0.69055),
    (-1.00165, -0.35805, -2.11293, -1.72842, 2.73117, -0.753, -0.67876),
    (-0.96139, -0.3407, -2.11626, -1.64339, 2.72761, -0.70904, -0.66607),
    (-0.92086, -0.32103, -2.11845, -1.55414, 2.72024, -0.66231, -0.65213),
    (-0.87987, -0.29872, -2.11879, -1.45993, 2.7082, -0.61242, -0.63651),
    (-0.83818, -0.2733, -2.11619, -1.3598, 2.69007, -0.55875, -0.61859),
    (-0.79546, -0.24405, -2.10889, -1.25237, 2.66342, -0.50038, -0.59746),
    (-0.75127, -0.20978, -2.09362, -1.13557, 2.62374, -0.4358, -0.57152),
)
"""The right arm's tool from (0.56, -0.45, 0.86) straight to x = 0.80 m in equal steps, yaw 0."""

_STEP = 0.24 / 9.0


def pr2_cases() -> TransitionCases:
    """For engines: the PR2's right arm in the thesis' shelf."""
    return _cases("pr2_right_arm", np.array(_PR2_PATH))


def gantry_cases(start: float = 0.56) -> TransitionCases:
    """The gantry, whose joints are the tool's x, y, z and yaw, does so from x = ``start`` m."""
    x = start + _STEP * np.arange(10)
    path = np.stack([x, np.full(10, -0.45), np.full(10, 0.86), np.zeros(10)], axis=1)
    return _cases(GANTRY, path)


def standard_constraints(problem: Problem) -> tuple[InteractionConstraint, ...]:
    """Contact, tilt, speed and bounds with their default limits."""
    return (
        ContactConstraint(problem),
        TiltConstraint(problem, TiltOptions()),
        SpeedConstraint(problem, SpeedOptions()),
        BoundsConstraint(problem, BoundsOptions()),
    )


def _cases(robot: str, path: Array) -> TransitionCases:
    return TransitionCases(
        problem=_problem(robot, path[0]),
        still=_still(path[0]),
        push=there_and_back(path[:6], _STEP),
        crash=there_and_back(path, _STEP),
        pushed="can",
        hit="post",
    )


def _still(joints: Array) -> Motion:
    trajectory = Trajectory.still(joints, 0.5)
    return Motion((MotionSegment(SegmentKind.TRANSIT, trajectory, opening=0.0),), opening=0.0)


def there_and_back(path: Array, step: float) -> Motion:
    """A sweep along joint positions (k, dof) whose tool poses are ``step`` m apart, and back."""
    times = np.arange(len(path), dtype=np.float64) * step / SPEED
    sweep = MotionSegment(
        SegmentKind.SWEEP, Trajectory.through(times, path), opening=0.0, settle=1.0
    )
    back = Trajectory.through(times, path[::-1])
    retract = MotionSegment(SegmentKind.RETRACT, back, opening=0.0, contact_free=True)
    return Motion((sweep, retract), opening=0.0)


def _problem(robot: str, joints: Array) -> Problem:
    """A can, two posts that stand 1 cm into its way on either side, others far from it.

    Grazed posts break the rules but do not stop the arm, however firmly an engine fixes them.
    """
    can = SceneObject("can", Cylinder(0.05, 0.18), Mobility.MOVABLE, 0.2, 0.3)
    post = SceneObject("post", Cylinder(0.03, 0.2), Mobility.IMMOVABLE, 0.5, 0.8)
    later = SceneObject("later", Cylinder(0.03, 0.2), Mobility.IMMOVABLE, 0.5, 0.8)
    target = SceneObject("target", Cylinder(0.03, 0.16), Mobility.TARGET, 0.2, 0.8)
    bystander = SceneObject(
        "bystander", Box(np.array([0.08, 0.08, 0.18])), Mobility.MOVABLE, 0.2, 0.8
    )
    objects = (can, post, later, target, bystander)
    places = ((0.66, -0.45), (0.80, -0.520), (0.86, -0.380), (0.66, -0.80), (0.95, -0.20))
    floor = thesis_workspace().floor
    poses = [
        make_pose([x, y, floor + item.shape.height / 2.0])
        for item, (x, y) in zip(objects, places, strict=True)
    ]
    board = Fixture("base", Box(np.array([0.60, 0.80, 0.04])), make_pose([0.78, -0.50, 0.75]))
    scene = Scene(robot, make_pose([0.0, 0.0, 0.0]), (board,), objects, thesis_workspace())
    return Problem("transition_cases", scene, SceneState(joints, np.array(poses)), joints, ())


def merged(first: Motion, second: Motion) -> Motion:
    """One motion after the other as one."""
    return Motion((*first.segments, *second.segments), first.opening)


def shift_along(before: npt.NDArray[np.float64], after: Array, direction: Array) -> float:
    """How far (m) a pose (7,) moved along a direction (2,)."""
    return float((after[:2] - before[:2]) @ direction)
