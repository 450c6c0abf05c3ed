"""Whether the execution of a plan did the task: what was grasped, and where it all ended."""

from __future__ import annotations

import numpy as np

from mamo_core.robots.kinematics import tool_transform
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, invert, matrix_from_pose
from mamo_core.types.motion import MotionSegment
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import SceneState

_GRIP_SLIP = 0.02
_OFF, _TURNED = 0.01, 0.1
"""How far a hand may be from a grasp, or a pre-grasp, of the problem: m, rad."""

_OPENING_SLACK = 1e-6


def check_retrieved(
    problem: Problem,
    segments: tuple[MotionSegment, ...],
    rollout: RolloutResult,
    robot: ArmModel,
) -> list[str]:
    """At the end the target is where the hand should have carried it."""
    index = problem.scene.target_index
    first = _first_held(problem, segments)
    before = matrix_from_pose(rollout.segment_states[first].object_poses[index])
    T_tool_target = invert(_tool(problem, segments[first], robot, 0)) @ before
    expected = _tool(problem, segments[-1], robot, -1) @ T_tool_target
    off = float(np.linalg.norm(rollout.final_state.object_poses[index][:3] - expected[:3, 3]))
    if off > _GRIP_SLIP:
        return [f"the target is {off * 100:.1f} cm away from where the hand should hold it"]
    return []


def check_grasp(
    problem: Problem,
    segments: tuple[MotionSegment, ...],
    states: tuple[SceneState, ...],
    robot: ArmModel,
) -> list[str]:
    """The hand takes hold of the target by one of the problem's grasps."""
    first = _first_held(problem, segments)
    pose = states[first].object_poses[problem.scene.target_index]
    T = invert(matrix_from_pose(pose)) @ _tool(problem, segments[first], robot, 0)
    if any(_same_pose(T, matrix_from_pose(grasp.T_object_tool)) for grasp in problem.grasps):
        return []
    return ["the target is held where no grasp of the problem puts the hand"]


def check_reached(problem: Problem, last: MotionSegment, robot: ArmModel) -> list[str]:
    """The hand ends where the approach of a grasp begins, open as that grasp wants it."""
    T_world_tool = _tool(problem, last, robot, -1)
    for grasp, T_world_pregrasp in zip(problem.grasps, problem.pregrasps, strict=True):
        is_open = abs(last.opening - grasp.opening) <= _OPENING_SLACK
        if is_open and _same_pose(T_world_tool, T_world_pregrasp):
            return []
    return ["the hand does not end, open, where the approach of a grasp begins"]


def _same_pose(T: Array, G: Array) -> bool:
    cosine = (np.trace(T[:3, :3].T @ G[:3, :3]) - 1.0) / 2.0
    turned = float(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return bool(np.linalg.norm(T[:3, 3] - G[:3, 3]) <= _OFF and turned <= _TURNED)


def _first_held(problem: Problem, segments: tuple[MotionSegment, ...]) -> int:
    target = problem.scene.objects[problem.scene.target_index].name
    return next(i for i, segment in enumerate(segments) if segment.held == target)


def _tool(problem: Problem, segment: MotionSegment, robot: ArmModel, row: int) -> Array:
    T_world_base = matrix_from_pose(problem.scene.T_world_base)
    return T_world_base @ tool_transform(robot, segment.trajectory.positions[row])
