"""What a grasp of two fingers can carry by friction.

Each finger is a soft finger: besides the friction force, the patch on which its pad presses resists
twisting about the normal. Force and torque share what friction there is, as an ellipsoid (the limit
surface of Howe and Cutkosky, "Practical force-motion models for sliding manipulation", 1996).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

import numpy as np

from mamo_core.robots.kinematics import finger_transforms
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, Box, Shape, invert
from mamo_core.types.scene import SceneObject

GRAVITY = 9.81

ACCELERATION = 4.0
"""What the hand may accelerate with while it holds something, m/s^2."""

SAFETY = 1.5
"""Grasps have to carry so many times what they need to."""

TILT = np.radians(25.0)
"""The farthest an object leans in the hand, rad: as far as constraints commonly let it."""

_SOFT = 0.0005
"""How far a pad gives way, m: it presses wherever the surface is no farther from it."""

_FLAT = 0.0005
"""What is no farther than this behind a finger's innermost point belongs to its pad, m."""

_GRID = 9


@dataclass(frozen=True)
class Pad:
    """Where the fingers press, in the tool frame, m: from ``back`` to ``front`` along x, and from
    ``-half_height`` to ``half_height`` along z."""

    back: float
    front: float
    half_height: float


@dataclass(frozen=True, eq=False)
class Patch:
    """Where pads and an object meet: its ``centre`` (3,) in the tool frame, and ``radius`` (m), the
    mean distance from it, which is the lever of friction against twisting under even pressure."""

    centre: Array
    radius: float


@lru_cache(maxsize=256)
def pad_of(arm: ArmModel, opening: float) -> Pad:
    """The pad of a gripper whose fingers stand ``opening`` (m) apart; both are alike."""
    T_tool_link = invert(arm.T_link_tool)
    corners: list[Array] = []
    for number, T_link_finger in finger_transforms(arm.links, arm.gripper.drive(opening)).items():
        T = T_tool_link @ T_link_finger
        for hull in arm.links[number].hulls:
            corners.append(_corners(hull) @ T[:3, :3].T + T[:3, 3])
    points = np.vstack(corners)
    points = points[(points[:, 1] > 0.0) & (points[:, 0] >= -arm.gripper.depth)]
    inner = points[points[:, 1] <= points[:, 1].min() + _FLAT]
    reach = float(np.abs(inner[:, 2]).max())
    return Pad(float(inner[:, 0].min()), float(inner[:, 0].max()), reach)


@cache
def _corners(hull: Path) -> Array:
    rows = [line.split()[1:4] for line in hull.read_text().splitlines() if line.startswith("v ")]
    return np.array(rows, dtype=np.float64)


def patch_of(shape: Shape, T_tool_object: Array, pad: Pad) -> Patch | None:
    """Where the pads press on an object that they have closed on; None if they miss it."""
    xs = np.linspace(pad.back, pad.front, _GRID)
    zs = np.linspace(-pad.half_height, pad.half_height, _GRID)
    points = np.stack(np.meshgrid(xs, [0.0], zs, indexing="ij"), axis=-1).reshape(-1, 3)
    T_object_tool = invert(T_tool_object)
    middle = (points[:, None, :] * T_object_tool[:3, :3]).sum(axis=2) + T_object_tool[:3, 3]
    widths = np.round(_chords(shape, middle, T_object_tool[:3, 1]), 9)
    touched = points[(widths > 0.0) & (widths >= widths.max() - 2.0 * _SOFT)]
    if not len(touched):
        return None
    centre = touched.mean(axis=0)
    return Patch(centre, float(np.linalg.norm(touched - centre, axis=1).mean()))


def _chords(shape: Shape, points: Array, direction: Array) -> Array:
    """Lengths (n,) of lines through ``points`` (n, 3) along a horizontal ``direction`` (3,) within
    the shape, in whose frame both are; 0 where they miss it."""
    above = np.abs(points[:, 2]) <= shape.height / 2.0
    if isinstance(shape, Box):
        first, last = np.full(len(points), -np.inf), np.full(len(points), np.inf)
        for axis in (0, 1):
            half, step = shape.size[axis] / 2.0, direction[axis]
            if abs(step) < 1e-9:
                above &= np.abs(points[:, axis]) <= half
                continue
            ends = (np.array([[-half], [half]]) - points[:, axis]) / step
            first, last = np.maximum(first, ends.min(axis=0)), np.minimum(last, ends.max(axis=0))
        return np.where(above, np.maximum(last - first, 0.0), 0.0)
    aside = points[:, 0] * direction[1] - points[:, 1] * direction[0]
    squares = np.maximum(shape.radius**2 - aside**2, 0.0)
    return np.where(above, 2.0 * np.sqrt(squares), 0.0)


def load_share(
    mass: float, friction: float, force: float, T_tool_object: Array, patch: Patch
) -> tuple[float, float]:
    """How much of what friction can give the weight takes: of the force, and of the torque.

    ``force``: of each finger, N. The torque is about the axis between the fingers; its lever is
    that from the patch to the centre of mass, the object leaning by at most ``TILT``.
    """
    weight, hold = mass * (GRAVITY + ACCELERATION), 2.0 * friction * force
    ahead, _, above = np.abs(T_tool_object[:3, 3] - patch.centre)
    lever = ahead * np.cos(TILT) + above * np.sin(TILT)
    return weight / hold, weight * lever / (hold * patch.radius)


def grip_fault(item: SceneObject, T_tool_object: Array, width: float, arm: ArmModel) -> str | None:
    """Why the fingers, with ``width`` (m) of an object between them, cannot carry it, as a cause.

    ``grip_missed``: the pads are beside it; ``grip_too_weak``: it would slip; ``grip_would_turn``:
    its weight would turn it between the fingers. None if they can.
    """
    patch = patch_of(item.shape, T_tool_object, pad_of(arm, width))
    if patch is None:
        return "grip_missed"
    held, turned = load_share(item.mass, item.friction, arm.gripper.force, T_tool_object, patch)
    if SAFETY * held >= 1.0:
        return "grip_too_weak"
    if SAFETY**2 * (held**2 + turned**2) >= 1.0:
        return "grip_would_turn"
    return None
