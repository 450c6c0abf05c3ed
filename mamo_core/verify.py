"""The independent check of a whole plan: nothing of the planner's state is used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mamo_core.interfaces.transition_model import RolloutOptions, TransitionModel
from mamo_core.robots.contact_free import check_meshes
from mamo_core.robots.exact_collision import ExactChecker
from mamo_core.robots.kinematics import tool_transform
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, invert, matrix_from_pose
from mamo_core.types.motion import Motion, MotionSegment
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import Mobility, SceneState
from mamo_core.types.solution import Plan

_CONTINUITY = 1e-6
_LIMIT_SLACK = 1e-6
_SPEED_SLACK = 1.01
_GRIP_SLIP = 0.02
_GRASP_OFF, _GRASP_TURNED = 0.01, 0.1


@dataclass(frozen=True, eq=False)
class VerifyReport:
    """``failures`` in words, empty if the plan holds; ``rollout``: its continuous execution.

    ``kinds`` of failures: names of constraints, lost, stalled, mesh, grasp, not_retrieved, form.
    ``outside_cpu``: CPU seconds that other processes spent.
    """

    failures: tuple[str, ...]
    rollout: RolloutResult | None
    kinds: tuple[str, ...] = ()
    outside_cpu: float = 0.0

    @property
    def ok(self) -> bool:
        """Whether every claim of the plan was confirmed."""
        return not self.failures

    @property
    def lost(self) -> bool:
        """Whether there is no verdict because the engine crashed or hung."""
        return self.rollout is not None and self.rollout.lost is not None


def verify(
    problem: Problem,
    plan: Plan,
    model: TransitionModel,
    robot: ArmModel,
    *,
    parameters: ParameterOverrides | None = None,
    trace_step: float | None = None,
) -> VerifyReport:
    """Replay the plan, retrieval included, in ONE continuous rollout from the initial state.

    Checked: form, joint limits, speeds and continuity of all trajectories; every interaction
    constraint at every step; contact-free segments against exact meshes, with the objects where
    the execution left them; that the fingers close on what they pick up to rearrange it; that the
    target ends in the hand, at home.
    """
    static = [*check_form(problem, plan), *check_trajectories(problem, plan, robot)]
    if static:
        return VerifyReport(tuple(static), None, kinds=("form",))
    whole = Motion(_segments(plan), plan.motions[0].opening)
    options = RolloutOptions(stop_early=False, trace_step=trace_step)
    rollout = model.rollout(problem.initial, whole, parameters=parameters, options=options)
    return _judged(problem, plan, rollout, robot)


def verify_executed(
    problem: Problem, plan: Plan, executed: Sequence[RolloutResult], robot: ArmModel
) -> VerifyReport:
    """The checks of ``verify`` on an execution that took place already, one motion at a time.

    ``executed``: one result for each of the plan's motions, each continued exactly from the one
    before. That they are what one rollout of the whole plan gives is taken on trust, so that this
    does for a search, and ``verify`` for whoever receives the plan.

    Raises:
        ValueError: the results are not one for each motion.
    """
    if len(executed) != len(plan.motions):
        raise ValueError(f"executed: {len(executed)} results for {len(plan.motions)} motions")
    static = [*check_form(problem, plan), *check_trajectories(problem, plan, robot)]
    if static:
        return VerifyReport(tuple(static), None, kinds=("form",))
    return _judged(problem, plan, _joined(executed), robot)


def _judged(problem: Problem, plan: Plan, rollout: RolloutResult, robot: ArmModel) -> VerifyReport:
    """What the continuous execution of a well-formed plan shows."""
    segments, opening = _segments(plan), plan.motions[0].opening
    found = _rollout_failures(rollout)
    if not found:
        states = rollout.segment_states
        found = {
            "mesh": check_meshes(problem.scene, segments, states, robot, opening),
            "grasp": [
                *check_grasp(problem, segments, states, robot),
                *check_closed(problem, segments, states, robot, opening),
            ],
            "not_retrieved": check_retrieved(problem, segments, rollout, robot),
        }
    kinds = tuple(kind for kind, texts in found.items() if texts)
    failures = tuple(text for texts in found.values() for text in texts)
    return VerifyReport(failures, rollout, kinds, rollout.outside_cpu)


def _joined(results: Sequence[RolloutResult]) -> RolloutResult:
    """One execution of several motions, each continued from the one before.

    What moved, and traces, are of the last alone: nothing here asks for them.
    """
    begins = np.cumsum([0.0, *(result.duration for result in results)])
    return replace(
        results[-1],
        violations=tuple(
            replace(violation, time=violation.time + begin)
            for result, begin in zip(results, begins, strict=False)
            for violation in result.violations
        ),
        contacts=frozenset().union(*(result.contacts for result in results)),
        stalled=any(result.stalled for result in results),
        duration=float(begins[-1]),
        steps=sum(result.steps for result in results),
        segment_states=tuple(s for result in results for s in result.segment_states),
        segment_times=tuple(
            time + float(begin)
            for result, begin in zip(results, begins, strict=False)
            for time in result.segment_times
        ),
        lost=next((result.lost for result in results if result.lost is not None), None),
        outside_cpu=0.0,
    )


def _segments(plan: Plan) -> tuple[MotionSegment, ...]:
    return tuple(segment for motion in plan.motions for segment in motion.segments)


def _rollout_failures(rollout: RolloutResult) -> dict[str, list[str]]:
    """By kind, in the order in which they happened."""
    found: dict[str, list[str]] = {}
    for violation in rollout.violations:
        found.setdefault(violation.constraint, []).append(str(violation))
    if rollout.lost is not None:
        found["lost"] = [rollout.lost]
    if rollout.stalled:
        found["stalled"] = ["the arm could not follow its trajectory"]
    return found


def check_form(problem: Problem, plan: Plan) -> list[str]:
    """Actions move movable objects; the retrieval, and it alone, holds the target to the end."""
    failures = []
    movable = {o.name for o in problem.scene.objects if o.mobility is Mobility.MOVABLE}
    target = problem.scene.objects[problem.scene.target_index].name
    for number, action in enumerate(plan.actions):
        if action.object_name not in movable:
            failures.append(f"action {number} rearranges {action.object_name!r}: not movable")
        for segment in action.motion.segments:
            if segment.held not in (None, action.object_name):
                failures.append(f"action {number} holds {segment.held!r}")
        if action.motion.segments[-1].held is not None:
            failures.append(f"action {number} ends with {action.object_name!r} in the hand")
    held = [segment.held for segment in plan.retrieval.segments]
    if held[-1] != target or any(name not in (None, target) for name in held):
        failures.append(f"the retrieval does not end with {target!r} in the hand")
    return failures


def check_trajectories(problem: Problem, plan: Plan, robot: ArmModel) -> list[str]:
    """Limits, speeds, continuity, start at the initial configuration and end at home."""
    failures = []
    where = problem.initial.joint_positions
    for number, motion in enumerate(plan.motions):
        for segment in motion.segments:
            label = f"motion {number} ({segment.kind})"
            positions, times = segment.trajectory.positions, segment.trajectory.times
            if np.abs(positions[0] - where).max() > _CONTINUITY:
                failures.append(f"{label}: does not start where the arm is")
            over = np.maximum(robot.lower - positions, positions - robot.upper)
            if over.max() > _LIMIT_SLACK:
                joint = robot.joint_names[int(np.argmax(over.max(axis=0)))]
                failures.append(f"{label}: {joint} exceeds its limit by {over.max():.2e} rad")
            if len(times) > 1:
                speeds = np.abs(np.diff(positions, axis=0)) / np.diff(times)[:, None]
                if (speeds > _SPEED_SLACK * robot.velocity).any():
                    failures.append(f"{label}: velocity limits exceeded")
            opening = segment.opening
            if not robot.gripper.closed - 1e-9 <= opening <= robot.gripper.max_opening + 1e-9:
                failures.append(f"{label}: opening {opening} m is not possible")
            where = positions[-1]
    if np.abs(where - problem.home).max() > _CONTINUITY:
        failures.append("the plan does not end at home")
    return failures


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
    for grasp in problem.grasps:
        G = matrix_from_pose(grasp.T_object_tool)
        cosine = (np.trace(T[:3, :3].T @ G[:3, :3]) - 1.0) / 2.0
        turned = float(np.arccos(np.clip(cosine, -1.0, 1.0)))
        if np.linalg.norm(T[:3, 3] - G[:3, 3]) <= _GRASP_OFF and turned <= _GRASP_TURNED:
            return []
    return ["the target is held where no grasp of the problem puts the hand"]


def check_closed(
    problem: Problem,
    segments: tuple[MotionSegment, ...],
    states: tuple[SceneState, ...],
    robot: ArmModel,
    opening: float,
) -> list[str]:
    """A rearranged object is held only after the fingers closed on it, on exact meshes.

    With the fingers as they were before they closed the hand must be clear of the object, as
    commanded then it must touch it. ``opening`` (m): the gripper's before the first segment.
    """
    scene = problem.scene
    target = scene.objects[scene.target_index].name
    failures = []
    openings = [opening, opening, *(segment.opening for segment in segments)]
    held_before = [None, *(segment.held for segment in segments)]
    for number, (segment, state) in enumerate(zip(segments, states, strict=True)):
        name = segment.held
        if name in (None, target, held_before[number]):
            continue
        others = [item for item in scene.entities[1:] if item != name]
        free = [
            _exact_free(problem, state, robot, width, others, segment)
            for width in openings[number : number + 2]
        ]
        if free != [True, False]:
            failures.append(f"{segment.kind}: the fingers do not close on {name!r} before")
    return failures


def _exact_free(
    problem: Problem,
    state: SceneState,
    robot: ArmModel,
    width: float,
    ignore: list[str],
    segment: MotionSegment,
) -> bool:
    """Whether the arm's meshes are clear where the segment starts, the fingers at ``width``."""
    world = ExactChecker(problem.scene, robot).world(
        state.object_poses, opening=width, ignore=ignore
    )
    return bool(world.free(segment.trajectory.positions[:1])[0])


def _first_held(problem: Problem, segments: tuple[MotionSegment, ...]) -> int:
    target = problem.scene.objects[problem.scene.target_index].name
    return next(i for i, segment in enumerate(segments) if segment.held == target)


def _tool(problem: Problem, segment: MotionSegment, robot: ArmModel, row: int) -> Array:
    T_world_base = matrix_from_pose(problem.scene.T_world_base)
    return T_world_base @ tool_transform(robot, segment.trajectory.positions[row])
