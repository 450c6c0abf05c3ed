"""Forward kinematics of a canonical arm in numpy: the reference the fast kernels agree with."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mamo_core.robots.model import ArmModel, LinkModel
from mamo_core.types.geometry import Array


def joint_transform(link: LinkModel, position: float) -> Array:
    """Transform (4, 4) of the joint itself at ``position`` (rad or m)."""
    return joint_transforms(link, np.array([position]))[0]


def joint_transforms(link: LinkModel, positions: Array) -> Array:
    """Transforms (k, 4, 4) of the joint itself at ``positions`` (k,) rad or m."""
    T = np.tile(np.eye(4), (len(positions), 1, 1))
    if link.prismatic:
        T[:, :3, 3] = positions[:, None] * link.axis
        return T
    x, y, z = link.axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned, bent = np.sin(positions), 1.0 - np.cos(positions)
    T[:, :3, :3] += turned[:, None, None] * K + bent[:, None, None] * (K @ K)
    return T


def link_transforms(arm: ArmModel, configuration: Array, opening: float) -> list[Array]:
    """``T_base_link`` (4, 4) of every link, in the order of ``arm.links``."""
    return list(link_transforms_along(arm, configuration[None, :], opening)[:, 0])


def link_transforms_along(arm: ArmModel, configurations: Array, opening: float) -> Array:
    """``T_base_link`` (links, k, 4, 4) of every link at configurations (k, dof)."""
    drives = np.full(len(configurations), arm.gripper.drive(opening))
    transforms: list[Array] = []
    for link in arm.links:
        positions = drives if link.coordinate < 0 else configurations[:, link.coordinate]
        joint = link.T_parent_joint @ joint_transforms(link, positions)
        transforms.append(joint if link.parent < 0 else transforms[link.parent] @ joint)
    return np.array(transforms)


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
