"""The independent check of a whole plan: nothing of the planner's state is used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mamo_core.interfaces.transition_model import Replay, RolloutOptions, TransitionModel
from mamo_core.robots.contact_free import check_meshes
from mamo_core.robots.exact_collision import ExactChecker
from mamo_core.robots.model import ArmModel
from mamo_core.robots.self_collision import check_self_collisions
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind
from mamo_core.types.problem import Problem, Task
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import Mobility
from mamo_core.types.solution import Plan
from mamo_core.verify_friction import check_friction
from mamo_core.verify_grasp import check_fingers, check_handling
from mamo_core.verify_limits import check_limits
from mamo_core.verify_replays import check_replays
from mamo_core.verify_task import check_grasp, check_reached, check_retrieved

_CONTINUITY = 1e-6
_CONTACT_FREE = (
    SegmentKind.TRANSIT,
    SegmentKind.GRIPPER,
    SegmentKind.REACH,
    SegmentKind.LIFT,
    SegmentKind.CARRY,
)
"""Segments in which the arm touches nothing but what it closes on, holds or lets go of."""


@dataclass(frozen=True, eq=False)
class VerifyReport:
    """``failures`` in words, empty if the plan holds; ``rollout``: its continuous execution.

    ``kinds`` of failures: names of constraints, lost, stalled, mesh, self_collision, grasp,
    not_retrieved, not_reached, replay, friction, form.
    ``outside_cpu``: CPU seconds that other processes spent. ``unasked``: in words, what the engine
    cannot answer.
    """

    failures: tuple[str, ...]
    rollout: RolloutResult | None
    kinds: tuple[str, ...] = ()
    outside_cpu: float = 0.0
    unasked: tuple[str, ...] = ()

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
    the execution left them; all segments for collisions of the robot with itself; that the
    fingers close on what they hold, from both sides, and friction carries it; that the task is
    done: the target ends in the hand, at home, or the open hand at a pre-grasp.
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


def verify_replays(
    report: VerifyReport,
    problem: Problem,
    plan: Plan,
    replays: Sequence[Replay],
    robot: ArmModel,
    parameters: ParameterOverrides | None = None,
) -> VerifyReport:
    """What else is found in worlds close to the problem's; ``kinds`` of failures: replay."""
    checker = ExactChecker(problem.scene, robot)
    found = check_replays(plan.motions, replays, checker, problem.scene, robot, parameters)
    return replace(report, failures=tuple(found), kinds=("replay",)) if found else report


def verify_by_friction(
    report: VerifyReport, problem: Problem, plan: Plan, model: TransitionModel, robot: ArmModel
) -> VerifyReport:
    """What else is found when fingers and friction alone hold things; ``kinds``: friction."""
    found = check_friction(problem, plan, model, robot)
    return replace(report, failures=tuple(found), kinds=("friction",)) if found else report


def _judged(problem: Problem, plan: Plan, rollout: RolloutResult, robot: ArmModel) -> VerifyReport:
    """What the continuous execution of a well-formed plan shows."""
    segments, opening = _segments(plan), plan.motions[0].opening
    found = _rollout_failures(rollout)
    if not found:
        states = rollout.segment_states
        found = {
            "mesh": check_meshes(problem.scene, segments, states, robot, opening),
            "self_collision": check_self_collisions(
                problem.scene, segments, states, robot, opening
            ),
            "grasp": check_fingers(problem, segments, states, robot, opening),
        }
        if problem.task is Task.REACH:
            found["not_reached"] = check_reached(problem, segments[-1], robot)
        else:
            found["grasp"] += check_grasp(problem, segments, states, robot)
            found["not_retrieved"] = check_retrieved(problem, segments, rollout, robot)
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
    """Actions move movable objects; a retrieval, and it alone, holds the target to the end.

    What is contact-free follows from what a segment is for; a plan cannot say otherwise.
    """
    failures = [
        f"{segment.kind}: a segment of this kind touches nothing, and this one may"
        for motion in plan.motions
        for segment in motion.segments
        if segment.kind in _CONTACT_FREE and not segment.contact_free
    ]
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
    if problem.task is Task.REACH:
        if any(name is not None for name in held):
            failures.append("the reach holds an object")
    elif held[-1] != target or any(name not in (None, target) for name in held):
        failures.append(f"the retrieval does not end with {target!r} in the hand")
    return failures if failures else check_handling(plan)


def check_trajectories(problem: Problem, plan: Plan, robot: ArmModel) -> list[str]:
    """Limits at 1 kHz, continuity, the start where the arm is, a retrieval's end at home."""
    failures = []
    where = problem.initial.joint_positions
    for number, motion in enumerate(plan.motions):
        opening = motion.opening
        for segment in motion.segments:
            label = f"motion {number} ({segment.kind})"
            positions = segment.trajectory.positions
            if np.abs(positions[0] - where).max() > _CONTINUITY:
                failures.append(f"{label}: does not start where the arm is")
            failures += [f"{label}: {text}" for text in check_limits(segment, opening, robot)]
            opening = segment.opening
            where = positions[-1]
    retrieves = problem.task is Task.RETRIEVE
    if retrieves and np.abs(where - problem.home).max() > _CONTINUITY:
        failures.append("the plan does not end at home")
    return failures
