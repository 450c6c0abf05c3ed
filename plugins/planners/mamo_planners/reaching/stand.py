"""Executions that go on from one another, and what becomes of them at a goal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from mamo_core.interfaces.arm_planner import ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion, MotionSegment
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Budget, Plan, Statistics
from mamo_planners.reaching.goals import Goal
from mamo_planners.reaching.retrieving import carried_home
from mamo_planners.search.rollouts import KEEP, Rollouts
from mamo_planners.search.stand import Engine, Line

if TYPE_CHECKING:
    from mamo_core.verify import VerifyReport


@dataclass(frozen=True, eq=False)
class ReachingParts:
    """What planners that reach work with."""

    problem: Problem
    arm: ArmModel
    kinematics: Kinematics
    collision: CollisionChecker
    arm_planner: ArmPlanner
    backend: TransitionModel
    verifier: Callable[[Plan], VerifyReport]


@dataclass(frozen=True, eq=False)
class Stand:
    """Where an execution of ``segments`` from the problem's start has come to.

    ``path`` (k, dof): the way of the arm so far.
    """

    line: Line
    segments: tuple[MotionSegment, ...]

    @property
    def state(self) -> SceneState:
        """Objects, and the arm where it was commanded to stop."""
        return self.line.state

    @property
    def path(self) -> Array:
        """The configurations (k, dof) the arm was led through."""
        return np.vstack([segment.trajectory.positions for segment in self.segments])


class Executions:
    """Simulates segments one after the other and verifies what reaches a goal."""

    def __init__(self, parts: ReachingParts, statistics: Statistics, budget: Budget) -> None:
        self._parts, self._statistics = parts, statistics
        self._budget = budget
        self._rollouts = Rollouts(statistics, budget)
        self._closed = parts.arm.gripper.closed
        self.last: RolloutResult | None = None
        """What was simulated last."""

    def start(self, opened: MotionSegment) -> Stand | None:
        """At home, after the hand has opened; None where even that breaks a constraint."""
        line = Line(Engine("backend", self._parts.backend), self._parts.problem.initial)
        return self._after(Stand(line, ()), (opened,))

    def after(self, stand: Stand, segment: MotionSegment) -> Stand | None:
        """One segment more, or None if the arm or an object does what it must not."""
        return self._after(stand, (segment,))

    def alone(self, segment: MotionSegment) -> RolloutResult:
        """What becomes of a segment with all objects at rest where they stand at first."""
        line = Line(Engine("backend", self._parts.backend), self._parts.problem.initial)
        begin = segment.trajectory.positions[0]
        at_begin = replace(line, state=line.state.with_joints(begin))
        return self._executed(at_begin, Motion((segment,), segment.opening))

    def finished(self, stand: Stand, goal: Goal, rng: np.random.Generator) -> Plan | None:
        """A verified plan that ends with what the task demands at ``goal``, where the arm is."""
        if goal.candidate is not None:
            with self._statistics.timed("retrieval"):
                rest = carried_home(self._parts, stand.state, stand.path, goal.candidate, rng)
            done = self._after(stand, rest)
            if done is None:
                return None
            stand = done
        return self.verified(stand.segments)

    def verified(self, segments: tuple[MotionSegment, ...]) -> Plan | None:
        """A plan of these segments, if it holds."""
        plan = Plan((), Motion(segments, self._closed))
        with self._statistics.timed("verification"):
            report = self._parts.verifier(plan)
        self._statistics.charge("verification", report.outside_cpu)
        self._budget.charge(report.outside_cpu)
        for failure in report.failures:
            self._statistics.failed("plan", "verification", failure)
        return plan if report.ok else None

    def _after(self, stand: Stand, segments: tuple[MotionSegment, ...]) -> Stand | None:
        opening = stand.segments[-1].opening if stand.segments else self._closed
        motion = Motion(segments, opening)
        result = self._executed(stand.line, motion)
        if not result.valid:
            return None
        return Stand(stand.line.after(result, motion), (*stand.segments, *segments))

    def _executed(self, line: Line, motion: Motion) -> RolloutResult:
        """What happens; why it is not valid is counted."""
        result = self._rollouts.one(line, motion, KEEP)
        self.last = result
        self._statistics.counts["steps"] += result.steps
        for violation in result.violations:
            self._statistics.failed(violation.subject, "reach", violation.constraint)
        self._statistics.failed("robot", "reach", "stalled", int(result.stalled))
        return result
