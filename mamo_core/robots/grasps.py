"""Side grasps of any standing shape: the tool's x axis horizontal, the fingers left and right."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mamo_core.errors import InputError, suggestion
from mamo_core.types.geometry import Array, Box, Cylinder, Shape, make_pose
from mamo_core.types.problem import Grasp


@dataclass(frozen=True)
class Hand:
    """``opening``: widest gap between the fingers, m. ``depth``: the farthest the tool goes past
    an object's near face, m; beyond it the open fingers narrow, or the palm begins. ``clearance``:
    how much wider than an object the fingers open, m."""

    opening: float
    depth: float
    clearance: float


HANDS = {"pr2_right_arm": Hand(0.0920, 0.05, 0.01), "panda": Hand(0.0799, 0.035, 0.015)}
"""By robot, as measured on the canonical arm models; the palm's planning spheres leave less."""

LEAST_CLEARANCE = 0.002
"""Faces that would leave less between the open fingers are not grasped, m."""

TOOL_PAST_CENTER = 0.025
"""The author's tool point lies this far past the object's centre, m."""

APPROACH = 0.10
"""Straight distance before the grasp, m."""

PREGRASP_CLEARANCE = 0.075
"""The author's distance from the near face to the tool before the approach, m."""

HEIGHTS = (0.09, 0.12, 0.065, 0.15)
"""Tool heights above the object's bottom, m. Lower ones, as the author's U(0.025, 0.075), leave no
room for the forearm between the hand and the shelf's front edge."""

TOP_GAP = 0.02
"""The tool stays this far below an object's top, m."""

CYLINDER_YAWS = 16

PITCHES = (0.25, 0.5)
"""How far the hand is dipped, rad."""

BELOW_TOP = (0.03, 0.045)
"""Where a dipped hand takes hold, below an object's top, m."""

LEAST_COVERED = 0.03
"""The fingers reach at least this far over the object, m."""


def hand_of(robot: str) -> Hand:
    """The hand of a known robot.

    Raises:
        InputError: default grasps are not known for this robot.
    """
    if robot not in HANDS:
        raise InputError(
            f"robot {robot!r}: no default grasps for it{suggestion(robot, HANDS)}; "
            "list the grasps in the problem instead of 'auto'"
        )
    return HANDS[robot]


def widths_between_fingers(shape: Shape, T_object_tool: Array) -> Array:
    """Widths (n,), m, of an upright ``shape`` along the y axes of tools (n, 4, 4) at it."""
    if isinstance(shape, Box):
        widths: Array = np.abs(T_object_tool[:, :3, 1]) @ shape.size
        return widths
    return np.full(len(T_object_tool), 2.0 * shape.radius)


def side_grasps(
    shape: Shape, hand: Hand, *, first_yaw: float = 0.0, heights: Sequence[float] = HEIGHTS
) -> tuple[Grasp, ...]:
    """Side grasps of an upright ``shape``; empty if no face fits between the fingers.

    Boxes are held across each face that is narrow enough, cylinders from 16 sides. Yaws are in
    the object's frame; ``heights`` (m above the bottom) come in their order, and for each the yaws
    nearest ``first_yaw`` (rad) first. The fingers open wider than the object as far as they can;
    whether they clear the object then is for the planner to check.
    """
    return tuple(
        _grasp(shape, hand, yaw, depth, height, min(width + hand.clearance, hand.opening))
        for height in _heights(shape.height, heights)
        for yaw, depth, width in _fitting(shape, hand, first_yaw)
    )


def dipped_grasps(
    shape: Shape, hand: Hand, *, first_yaw: float = 0.0, pitches: Sequence[float] = PITCHES
) -> tuple[Grasp, ...]:
    """As ``side_grasps``, near the top and with the hand dipped by ``pitches`` (rad).

    The hand comes from above whatever stands in front. It is as far from the object as the fingers
    need it to be, so a pitch that leaves too little of them on the object is left out.
    """
    return tuple(
        grasp
        for yaw, depth, width in _fitting(shape, hand, first_yaw)
        for pitch in pitches
        for below in BELOW_TOP
        if below < shape.height / 2.0
        for grasp in _dipped(shape, hand, yaw, pitch, depth, width, below)
    )


def _dipped(
    shape: Shape,
    hand: Hand,
    yaw: float,
    pitch: float,
    half_depth: float,
    width: float,
    below: float,
) -> Iterator[Grasp]:
    """The grasp ``below`` (m) the top, if the fingers cover enough of the object."""
    along = min(TOOL_PAST_CENTER, hand.depth * np.cos(pitch) - half_depth)
    covered = min(along + half_depth, below / np.tan(pitch))
    if covered < LEAST_COVERED:
        return
    position = [along * np.cos(yaw), along * np.sin(yaw), shape.height / 2.0 - below]
    approach = max(APPROACH, along + half_depth + PREGRASP_CLEARANCE)
    opening = min(width + hand.clearance, hand.opening)
    yield Grasp(_dipped_pose(position, yaw, pitch), approach, opening)


def _dipped_pose(position: list[float], yaw: float, pitch: float) -> Array:
    """The pose (7,) of ``tool_matrix(position, yaw, pitch)``."""
    cy, sy = np.cos(yaw / 2.0), np.sin(yaw / 2.0)
    cp, sp = np.cos(pitch / 2.0), np.sin(pitch / 2.0)
    return np.array([*position, cy * cp, -sy * sp, cy * sp, sy * cp])


def _fitting(shape: Shape, hand: Hand, first_yaw: float) -> Iterator[tuple[float, float, float]]:
    """Sides that are narrow enough."""
    return (side for side in _sides(shape, first_yaw) if side[2] + LEAST_CLEARANCE <= hand.opening)


def _sides(shape: Shape, first_yaw: float) -> Iterator[tuple[float, float, float]]:
    """Approach yaw, half depth along it and width across it."""
    if isinstance(shape, Cylinder):
        for k in _alternating(CYLINDER_YAWS):
            yield first_yaw + k * 2.0 * np.pi / CYLINDER_YAWS, shape.radius, 2.0 * shape.radius
        return
    yield from sorted(_faces(shape), key=lambda face: _angle(face[0], first_yaw))


def _faces(shape: Box) -> Iterator[tuple[float, float, float]]:
    length, width = float(shape.size[0]), float(shape.size[1])
    yield 0.0, length / 2.0, width
    yield np.pi / 2.0, width / 2.0, length
    yield np.pi, length / 2.0, width
    yield -np.pi / 2.0, width / 2.0, length


def _alternating(count: int) -> Iterator[int]:
    """0, 1, -1, 2, -2, ...: ``count`` turns, the smallest first."""
    for k in range(count):
        yield (k + 1) // 2 * (1 if k % 2 else -1)


def _angle(a: float, b: float) -> float:
    """Angle between two headings, rounded so that ties keep their order on every machine."""
    return round(abs(float(np.angle(np.exp(1j * (a - b))))), 6)


def _heights(height: float, heights: Sequence[float]) -> tuple[float, ...]:
    """Tool heights above the bottom; a low object is held at half its height."""
    fitting = tuple(h for h in heights if h <= height - TOP_GAP)
    return fitting or (height / 2.0,)


def _grasp(
    shape: Shape, hand: Hand, yaw: float, half_depth: float, height: float, opening: float
) -> Grasp:
    along = min(TOOL_PAST_CENTER, hand.depth - half_depth)
    position = [along * np.cos(yaw), along * np.sin(yaw), height - shape.height / 2.0]
    # Far enough back for the fingers to clear the object before they come in.
    approach = max(APPROACH, along + half_depth + PREGRASP_CLEARANCE)
    return Grasp(make_pose(position, yaw), approach, opening)
