"""Whether a controller would accept the trajectories of a plan: limits at 1 kHz, rest to rest."""

from __future__ import annotations

import numpy as np

from mamo_core.robots.model import ArmModel, GripperModel
from mamo_core.types.geometry import Array
from mamo_core.types.motion import MotionSegment, Trajectory

CONTROL_STEP = 0.001
"""A controller's step, s."""

SLACK = 0.01
"""Share by which limits of velocity, acceleration and jerk may be exceeded: what differences of
rounded samples add to limits that are used in full."""

_POSITION_SLACK = 1e-6
_REST = 1e-6
_AT_REST = 4
"""Samples at rest around a trajectory: as many as a difference for jerk spans."""


def check_limits(segment: MotionSegment, before: float, robot: ArmModel) -> list[str]:
    """What a segment exceeds, in words; ``before`` (m) is the opening that it starts with."""
    trajectory = segment.trajectory
    return [
        *check_positions(trajectory, robot),
        *check_rest(trajectory),
        *check_derivatives(trajectory, robot),
        *check_gripper(segment, before, robot.gripper),
    ]


def check_positions(trajectory: Trajectory, robot: ArmModel) -> list[str]:
    """Joint positions beyond their limits."""
    positions = samples(trajectory)
    over = np.maximum(robot.lower - positions, positions - robot.upper).max(axis=0)
    joint = int(np.argmax(over))
    if over[joint] <= _POSITION_SLACK:
        return []
    return [f"{robot.joint_names[joint]} exceeds its limit by {over[joint]:.2e} rad"]


def check_rest(trajectory: Trajectory) -> list[str]:
    """Whether it starts and ends at rest."""
    ends = {"start": trajectory.velocities[0], "end": trajectory.velocities[-1]}
    return [
        f"it does not {name} at rest, but with {np.abs(velocity).max():.2g} rad/s"
        for name, velocity in ends.items()
        if np.abs(velocity).max() > _REST
    ]


def check_derivatives(trajectory: Trajectory, robot: ArmModel) -> list[str]:
    """Velocities, accelerations and jerks beyond their limits."""
    failures = []
    for name, share in shares(trajectory, robot).items():
        joint = int(np.argmax(share))
        if share[joint] > 1.0 + SLACK:
            where = robot.joint_names[joint]
            failures.append(f"{name} limit exceeded: {where} at {100.0 * share[joint]:.0f} %")
    return failures


def check_gripper(segment: MotionSegment, before: float, gripper: GripperModel) -> list[str]:
    """An opening that is impossible, or that the fingers cannot get to in time."""
    opening = segment.opening
    failures = []
    if not gripper.closed - 1e-9 <= opening <= gripper.max_opening + 1e-9:
        failures.append(f"opening {opening} m is not possible")
    share = gripper_share(segment, before, gripper)
    if share > 1.0 + SLACK:
        failures.append(f"gripper speed limit exceeded: {100.0 * share:.0f} %")
    return failures


def gripper_share(segment: MotionSegment, before: float, gripper: GripperModel) -> float:
    """Share of the gripper's speed that a segment uses; infinite if it takes no time."""
    way, duration = abs(segment.opening - before), segment.trajectory.duration
    if way <= 1e-9:
        return 0.0
    return way / duration / gripper.speed if duration > 0.0 else np.inf


def shares(trajectory: Trajectory, robot: ArmModel) -> dict[str, Array]:
    """Largest share (dof,) that each joint uses of its velocity, acceleration and jerk limits."""
    limits = robot.limits
    values, found = samples(trajectory), {}
    for name, limit in (
        ("velocity", limits.velocity),
        ("acceleration", limits.acceleration),
        ("jerk", limits.jerk),
    ):
        values = np.diff(values, axis=0) / CONTROL_STEP
        found[name] = np.abs(values).max(axis=0) / limit
    return found


def samples(trajectory: Trajectory) -> Array:
    """Positions (k, dof) at a controller's steps, at rest for a few before and after."""
    count = int(np.ceil(trajectory.duration / CONTROL_STEP))
    steps = np.arange(-_AT_REST, count + _AT_REST + 1, dtype=np.float64)
    return trajectory.at(CONTROL_STEP * steps)
