"""How the force of a gripper comes from the joints of its fingers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mamo_core.robots.model import ArmModel, GripperModel

GIVE = 0.002
"""How far from where it is sent to a finger presses with all of the gripper's force, m."""


def finger_count(arm: ArmModel) -> int:
    """Number of joints that move the fingers together."""
    return sum(link.coordinate < 0 for link in arm.links)


def finger_effort(arm: ArmModel) -> float:
    """What every finger joint is driven with (N m, or N) to press with the gripper's force.

    The work of all joints is that of both fingers (virtual work): n effort dq = force dgap.
    """
    return arm.gripper.force * _least_slope(arm.gripper) / finger_count(arm)


def finger_stiffness(arm: ArmModel) -> float:
    """Gain (N m/rad, or N/m) of a servo on each finger joint that gives way by ``GIVE``."""
    return finger_effort(arm) * _least_slope(arm.gripper) / (2.0 * GIVE)


@dataclass(frozen=True)
class FingerDrive:
    """One finger joint in an engine that cannot couple joints.

    ``effort``: the most it is driven with, N m or N. ``follows``: place among the finger joints of
    the one where this one has to stand as well, by a linkage; None: a motor drives it.
    """

    effort: float
    follows: int | None


def finger_drives(arm: ArmModel, rigid: float) -> tuple[FingerDrive, ...]:
    """How to drive finger joints apart: those of the hand's own fingers press, tips follow them.

    ``rigid``: effort of a linkage, N m or N.
    """
    fingers = [n for n, link in enumerate(arm.links) if link.coordinate < 0]
    parents = [arm.links[n].parent for n in fingers]
    driven = sum(parent not in fingers for parent in parents)
    return tuple(
        FingerDrive(rigid, fingers.index(parent))
        if parent in fingers
        else FingerDrive(finger_effort(arm) * len(fingers) / driven, None)
        for parent in parents
    )


def _least_slope(gripper: GripperModel) -> float:
    """The least change of the gap with the joints' position, m/rad (or 1), over quarters of both.

    With the least, no finger presses with more than the gripper's force.
    """
    gaps, drives = gripper.drive_of_opening.T
    quarters = np.linspace(drives[0], drives[-1], 5)
    return float((np.diff(np.interp(quarters, drives, gaps)) / np.diff(quarters)).min())
