"""The continuous execution so far: candidates are tried from where it really stands."""

from __future__ import annotations

from collections.abc import Callable

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
from mamo_core.types.solution import Statistics

_KEEP = RolloutOptions(keep=True)
_TRANSIT_SPEED = 0.5
_HOME_TOLERANCE = 1e-6

Accept = Callable[[SceneState], bool]
ExecutionFactory = Callable[[Statistics], "Execution"]


class Execution:
    """Grows one action at a time from the initial state.

    A candidate is first rolled out alone, from its sweep on, which is cheap. If that is valid the
    whole motion is executed from the engine's exact state, so that what the search believes is
    what the continuous execution does (needs the capability exact_continuation).
    """

    def __init__(
        self,
        problem: Problem,
        arm: ArmModel,
        model: TransitionModel,
        collision: CollisionChecker,
        arm_planner: ArmPlanner,
        statistics: Statistics,
    ) -> None:
        self._problem, self._arm, self._model = problem, arm, model
        self._collision, self._arm_planner = collision, arm_planner
        self._stats = statistics
        self._token: object = None
        self.state = problem.initial

    def commit(self, action: RearrangementAction, accept: Accept | None) -> bool:
        """Execute the action if it is valid, moves its object and passes ``accept``."""
        sweep = action.motion.after_transit()
        trial = self._rollout(self.state.with_joints(sweep.start), sweep, None, None)
        if not self._good(trial, action, accept):
            return False
        self._stats.counts["valid_rollouts"] += 1
        whole = self._rollout(self.state, action.motion, self._token, _KEEP)
        if not self._good(whole, action, accept):
            self._stats.failed(action.object_name, action.kind, "not_reproduced")
            return False
        # The next plan starts where this one commanded the arm to stop.
        self.state = whole.final_state.with_joints(action.motion.end)
        self._token = whole.continuation
        return True

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
        """Whether the retrieval is valid in the continuous execution."""
        result = self._rollout(self.state, motion, self._token, None)
        self._count_failures(result, "arm", "retrieval")
        return result.valid

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
        if result.stalled:
            self._stats.failed(subject, action, "stalled")
        for violation in result.violations[:1]:
            self._stats.failed(subject, action, violation.constraint)

    def _rollout(
        self, state: SceneState, motion: Motion, token: object, options: RolloutOptions | None
    ) -> RolloutResult:
        self._stats.counts["rollouts"] += 1
        with self._stats.timed("rollouts"):
            return self._model.rollout(state, motion, options=options, continue_from=token)
