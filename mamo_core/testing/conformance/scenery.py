"""Small scenes for the gantry, and motions written down as tool positions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.testing.gantry import GANTRY
from mamo_core.types.geometry import Array, Box, make_pose
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.problem import Problem
from mamo_core.types.scene import (
    Fixture,
    Mobility,
    Scene,
    SceneObject,
    SceneState,
    Workspace,
)

GRAVITY = 9.81
FRICTION = 0.5
"""Of boxes, unless a check needs another."""

ALL = RolloutOptions(stop_early=False)
PARKED = np.array([0.0, 0.0, 1.5, 0.0])
"""The tool far above everything."""


def box(name: str, size: Sequence[float], mass: float = 0.3, friction: float = 0.5) -> SceneObject:
    """A movable box, ``size`` (3,) m."""
    return SceneObject(name, Box(np.array(size)), Mobility.MOVABLE, mass, friction)


def placed(item: SceneObject, x: float, y: float, yaw: float = 0.0) -> tuple[SceneObject, Array]:
    """The object standing on the board."""
    return item, make_pose([x, y, item.shape.height / 2.0], yaw)


def on_a_board(
    *placements: tuple[SceneObject, Array],
    start: Array = PARKED,
    fixtures: Sequence[Fixture] = (),
) -> Problem:
    """Objects on a board of 4 m x 4 m whose top is z = 0; a target stands far away."""
    board = Fixture("board", Box(np.array([4.0, 4.0, 0.1])), make_pose([0.0, 0.0, -0.05]))
    target = SceneObject("target", Box(np.full(3, 0.05)), Mobility.TARGET, 0.3, 0.8)
    given = [item.name for item, _ in placements]
    extra = [] if "target" in given else [placed(target, 1.9, 1.9)]
    items, poses = zip(*placements, *extra, strict=True)
    space = Workspace(np.array([-2.0, -2.0, 0.0]), np.array([2.0, 2.0, 2.0]))
    scene = Scene(GANTRY, make_pose([0.0, 0.0, 0.0]), (board, *fixtures), items, space)
    return Problem("conformance", scene, SceneState(start, np.array(poses)), start, ())


def still(seconds: float, where: Array = PARKED) -> Motion:
    """The arm keeps still."""
    trajectory = Trajectory.still(where, seconds)
    return Motion((MotionSegment(SegmentKind.TRANSIT, trajectory, 0.0),), 0.0)


def line(
    start: Array,
    end: Array,
    speed: float,
    *,
    held: str | None = None,
    settle: float = 0.0,
    ramp: float = 0.1,
) -> MotionSegment:
    """Straight from ``start`` to ``end`` (4,), gaining speed within ``ramp`` s; it ends at speed.

    The distance must be long enough to gain it.
    """
    distance = float(np.linalg.norm((end - start)[:3]))
    cruise = (distance - 0.5 * speed * ramp) / speed
    if cruise < 0.0:
        raise ValueError(f"line: {distance:g} m are too short to gain {speed:g} m/s")
    times, gone, speeds = np.array([[0.0, ramp], [0.0, 0.5 * speed * ramp], [0.0, speed]])
    if cruise > 0.0:
        times, gone = np.append(times, ramp + cruise), np.append(gone, distance)
        speeds = np.append(speeds, speed)
    way = (end - start) / distance
    path, velocities = start + gone[:, None] * way, speeds[:, None] * way
    trajectory = Trajectory(times, path, velocities)
    return MotionSegment(SegmentKind.SWEEP, trajectory, 0.0, held, False, settle)


def up(where: Array, height: float = 0.3, settle: float = 0.0) -> MotionSegment:
    """Straight up, fast."""
    end = where + np.array([0.0, 0.0, height, 0.0])
    return line(where, end, 0.5, settle=settle)


def motion(*segments: MotionSegment) -> Motion:
    """The segments with the hand closed."""
    return Motion(segments, 0.0)


def tool(x: float, y: float, z: float, yaw: float = 0.0) -> Array:
    """A configuration (4,) of the gantry."""
    return np.array([x, y, z, yaw])


def heading(angle: float) -> Array:
    """A direction (4,) of the tool in the plane."""
    return np.array([np.cos(angle), np.sin(angle), 0.0, 0.0])


def tilt_deg(pose: Array) -> float:
    """Angle of a pose's z axis to the vertical, degrees."""
    x, y = pose[4:6]
    return float(np.degrees(np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0))))
