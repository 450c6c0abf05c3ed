"""The last check of a plan: fingers and friction alone hold what it carries."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mamo_core.interfaces.transition_model import RolloutOptions, TransitionModel
from mamo_core.robots.kinematics import tool_transform
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, invert, matrix_from_pose
from mamo_core.types.motion import Motion, MotionSegment
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.solution import Plan
from mamo_core.verify_grasp import Hold, holds

SLIP = 0.02
"""The farthest an object may end from where the hand should have brought it, m."""


@dataclass(frozen=True)
class Slip:
    """How far an object ended from where the hand should have brought it: m, rad.

    ``let_go``: how far it then went from there, m; 0 where the plan ends with it in the hand.
    """

    name: str
    distance: float
    angle: float
    let_go: float


@dataclass(frozen=True, eq=False)
class FrictionReport:
    """``failures`` in words, none if friction does it; ``slips``: of the holds that were executed;
    ``rollout``: the execution."""

    failures: tuple[str, ...]
    slips: tuple[Slip, ...]
    rollout: RolloutResult


def check_friction(
    problem: Problem, plan: Plan, model: TransitionModel, robot: ArmModel
) -> list[str]:
    """What goes wrong when a plan is executed with fingers and friction, in words."""
    return list(execute_by_friction(problem, plan, model, robot).failures)


def execute_by_friction(
    problem: Problem,
    plan: Plan,
    model: TransitionModel,
    robot: ArmModel,
    *,
    stop_early: bool = True,
) -> FrictionReport:
    """Execute the whole plan in one rollout of a ``model`` without welds.

    Every constraint is kept, the arm arrives, and whatever is carried ends within 2 cm of where the
    hand should have brought it, and stays there when it is let go. ``stop_early``: at the first
    constraint that is broken.
    """
    segments = tuple(segment for motion in plan.motions for segment in motion.segments)
    whole = Motion(segments, plan.motions[0].opening)
    rollout = model.rollout(problem.initial, whole, options=RolloutOptions(stop_early=stop_early))
    failures = [f"by friction: {violation}" for violation in rollout.violations]
    if rollout.lost is not None:
        failures.append(f"by friction: {rollout.lost}")
    if rollout.stalled:
        failures.append("by friction: the arm could not follow its trajectory")
    slips = () if rollout.lost is not None else tuple(_slips(problem, segments, rollout, robot))
    failures += [text for slip in slips for text in _complaints(slip)]
    return FrictionReport(tuple(failures), slips, rollout)


def _complaints(slip: Slip) -> Iterator[str]:
    if slip.distance > SLIP:
        yield f"by friction: {slip.name!r} slips by {slip.distance * 100:.1f} cm in the hand"
    if slip.let_go > SLIP:
        yield f"by friction: {slip.name!r} moves by {slip.let_go * 100:.1f} cm when it is let go"


def _slips(
    problem: Problem, segments: tuple[MotionSegment, ...], rollout: RolloutResult, robot: ArmModel
) -> Iterator[Slip]:
    poses = [state.object_poses for state in (*rollout.segment_states, rollout.final_state)]
    executed = len(rollout.segment_states)
    for hold in holds(segments[:executed]):
        yield _slip(problem, hold, segments, poses, robot)


def _slip(
    problem: Problem,
    hold: Hold,
    segments: tuple[MotionSegment, ...],
    poses: list[Array],
    robot: ArmModel,
) -> Slip:
    """``poses``: of all objects at the start of each segment that was executed, and at the end."""
    place = problem.scene.index(hold.name)
    base = matrix_from_pose(problem.scene.T_world_base)
    T_first = base @ tool_transform(robot, segments[hold.first].trajectory.positions[0])
    T_last = base @ tool_transform(robot, segments[hold.last].trajectory.positions[-1])
    before = matrix_from_pose(poses[hold.first][place])
    after = matrix_from_pose(poses[hold.last + 1][place])
    expected = T_last @ invert(T_first) @ before
    cosine = (np.trace(expected[:3, :3].T @ after[:3, :3]) - 1.0) / 2.0
    rest = poses[hold.last + 2][place] if hold.last + 2 < len(poses) else poses[-1][place]
    return Slip(
        hold.name,
        float(np.linalg.norm(after[:3, 3] - expected[:3, 3])),
        float(np.arccos(np.clip(cosine, -1.0, 1.0))),
        float(np.linalg.norm(rest[:3] - after[:3, 3])),
    )
