"""The continuous execution so far: candidates are tried from where it really stands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mamo_core.interfaces.arm_planner import ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.interfaces.transition_model import RolloutOptions, TransitionModel
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import time_path
from mamo_core.types.action import RearrangementAction
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Budget, Statistics

_KEEP = RolloutOptions(keep=True)
_TRANSIT_SPEED = 0.5
_HOME_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class _Line:
    """The continuous execution in one engine: where it stands, and how to go on there."""

    name: str
    model: TransitionModel
    state: SceneState
    token: object = None

    def after(self, result: RolloutResult, motion: Motion) -> _Line:
        """The next motion starts where this one commanded the arm to stop."""
        state = result.final_state.with_joints(motion.end)
        return replace(self, state=state, token=result.continuation)


Accept = Callable[[SceneState], bool]
ContactFree = Callable[[Motion, Sequence[SceneState]], bool]
"""Whether a motion's contact-free segments touch nothing, given the state each starts from."""
ExecutionFactory = Callable[[Statistics, Budget], "Execution"]


class Execution:
    """Grows one action at a time from the initial state.

    A candidate is first rolled out alone, from its sweep on, which is cheap. If that is valid the
    whole motion is executed from the engine's exact state, so that what the search believes is
    what the continuous execution does (needs the capability exact_continuation). Other engines
    are asked last; each executes the plan in a line of its own.
    """

    def __init__(
        self,
        problem: Problem,
        arm: ArmModel,
        engines: Sequence[tuple[str, TransitionModel]],
        collision: CollisionChecker,
        arm_planner: ArmPlanner,
        contact_free: ContactFree,
        statistics: Statistics,
        budget: Budget,
    ) -> None:
        """``engines``: the first one's state is what the search plans from."""
        self._contact_free = contact_free
        self._problem, self._arm = problem, arm
        self._collision, self._arm_planner = collision, arm_planner
        self._stats, self._budget = statistics, budget
        self._own, *self._others = [_Line(n, m, problem.initial) for n, m in engines]

    @property
    def state(self) -> SceneState:
        """Where the first engine stands."""
        return self._own.state

    def commit(self, action: RearrangementAction, accept: Accept | None) -> bool:
        """Execute the action if it is valid, moves its object and passes ``accept``."""
        sweep = action.motion.after_transit()
        alone = replace(self._own, state=self.state.with_joints(sweep.start), token=None)
        trial = self._rollout(alone, sweep, None)
        if not self._good(trial, action, accept):
            return False
        self._stats.counts["valid_rollouts"] += 1
        whole = self._rollout(self._own, action.motion, _KEEP)
        if not self._good(whole, action, accept):
            self._stats.failed(action.object_name, action.kind, "not_reproduced")
            return False
        elsewhere = self._elsewhere(action, accept)
        if elsewhere is None:
            return False
        self._own, self._others = self._own.after(whole, action.motion), elsewhere
        return True

    def _elsewhere(self, action: RearrangementAction, accept: Accept | None) -> list[_Line] | None:
        """The other engines' lines after the action; None if it fails in one of them."""
        lines = []
        for line in self._others:
            result = self._rollout(line, action.motion, _KEEP)
            if not (self._good(result, action, accept) and self._free(result, action.motion)):
                self._stats.failed(action.object_name, action.kind, f"not_valid_in_{line.name}")
                return None
            lines.append(line.after(result, action.motion))
        return lines

    def _free(self, result: RolloutResult, motion: Motion) -> bool:
        """Whether a way that was planned for the first engine's poses is free for these, too."""
        return self._contact_free(motion, result.segment_states)

    def retrieval_from_here(self, retrieval: Motion, rng: np.random.Generator) -> Motion | None:
        """The retrieval with a closed-gripper transit home in front, if the arm is elsewhere."""
        home = self._problem.home
        if np.abs(self.state.joint_positions - home).max() < _HOME_TOLERANCE:
            return retrieval
        opening = self._arm.gripper.closed
        world = self._collision.world(self.state.object_poses, opening=opening)
        with self._stats.timed("arm_planning"):
            plan = self._arm_planner.plan(self.state.joint_positions, home[None, :], world, rng)
        if plan.path is None:
            self._stats.failed("arm", "home", str(plan.status))
            return None
        transit = time_path(plan.path, self._arm.velocity, scale=_TRANSIT_SPEED)
        segment = MotionSegment(SegmentKind.TRANSIT, transit, opening, contact_free=True)
        return Motion((segment, *retrieval.segments), opening)

    def retrieval_holds(self, motion: Motion) -> bool:
        """Whether the retrieval is valid in the continuous execution, in every engine."""
        for line in (self._own, *self._others):
            result = self._rollout(line, motion, None)
            self._count_failures(result, "arm", "retrieval")
            if line is self._own and not result.valid:
                return False
            if line is not self._own and not (result.valid and self._free(result, motion)):
                self._stats.failed("arm", "retrieval", f"not_valid_in_{line.name}")
                return False
        return True

    def _good(
        self, result: RolloutResult, action: RearrangementAction, accept: Accept | None
    ) -> bool:
        self._count_failures(result, action.object_name, action.kind)
        if not result.valid:
            return False
        if action.object_name not in result.moved:
            self._stats.failed(action.object_name, action.kind, "unmoved")
            return False
        end = action.motion.end
        world = self._collision.world(
            result.final_state.object_poses, opening=action.motion.segments[-1].opening
        )
        if not world.free(end)[0]:
            self._stats.failed(action.object_name, action.kind, "arm_blocked_after")
            return False
        if accept is not None and not accept(result.final_state):
            self._stats.failed(action.object_name, action.kind, "no_gain")
            return False
        return True

    def _count_failures(self, result: RolloutResult, subject: str, action: str) -> None:
        if result.lost is not None:
            self._stats.failed(subject, action, result.lost)
        if result.stalled:
            self._stats.failed(subject, action, "stalled")
        for violation in result.violations[:1]:
            self._stats.failed(subject, action, violation.constraint)

    def _rollout(
        self, line: _Line, motion: Motion, options: RolloutOptions | None
    ) -> RolloutResult:
        self._stats.counts["rollouts"] += 1
        with self._stats.timed("rollouts"):
            result = line.model.rollout(
                line.state, motion, options=options, continue_from=line.token
            )
        self._stats.charge("rollouts", result.outside_cpu)
        self._budget.charge(result.outside_cpu)
        return result
