"""Forward kinematics of a canonical arm in numpy: the reference the fast kernels agree with."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mamo_core.robots.model import ArmModel, LinkModel
from mamo_core.types.geometry import Array


def joint_transform(link: LinkModel, position: float) -> Array:
    """Transform (4, 4) of the joint itself at ``position`` (rad or m)."""
    T = np.eye(4)
    if link.prismatic:
        T[:3, 3] = link.axis * position
        return T
    x, y, z = link.axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    T[:3, :3] += np.sin(position) * K + (1.0 - np.cos(position)) * (K @ K)
    return T


def link_transforms(arm: ArmModel, configuration: Array, opening: float) -> list[Array]:
    """``T_base_link`` (4, 4) of every link, in the order of ``arm.links``."""
    drive = arm.gripper.drive(opening)
    transforms: list[Array] = []
    for link in arm.links:
        position = drive if link.coordinate < 0 else float(configuration[link.coordinate])
        parent = np.eye(4) if link.parent < 0 else transforms[link.parent]
        transforms.append(parent @ link.T_parent_joint @ joint_transform(link, position))
    return transforms


def tool_transform(arm: ArmModel, configuration: Array) -> Array:
    """``T_base_tool`` (4, 4)."""
    return link_transforms(arm, configuration, arm.gripper.closed)[arm.tool_link] @ arm.T_link_tool


def finger_transforms(links: Sequence[LinkModel], drive: float) -> dict[int, Array]:
    """Transforms (4, 4) of the finger links in the link that carries them, by link number."""
    transforms: dict[int, Array] = {}
    for number, link in enumerate(links):
        if link.coordinate < 0:
            parent = transforms.get(link.parent, np.eye(4))
            transforms[number] = parent @ link.T_parent_joint @ joint_transform(link, drive)
    return transforms
