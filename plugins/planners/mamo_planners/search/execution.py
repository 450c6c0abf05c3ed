"""The continuous execution: candidates are tried from where it really stands."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np

from mamo_core.interfaces.arm_planner import ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import time_path
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Budget, Statistics
from mamo_planners.search.stand import Engine, Line, Stand

_KEEP = RolloutOptions(keep=True)
_TRANSIT_SPEED = 0.5
_HOME_TOLERANCE = 1e-6
_SIDE_BY_SIDE = 4


Accept = Callable[[SceneState], bool]
ContactFree = Callable[[Motion, Sequence[SceneState]], bool]
"""Whether a motion's contact-free segments touch nothing, given the state each starts from."""
Clear = Callable[[Motion, SceneState], bool]
"""Whether a retrieval surely touches nothing but the target, from a state at rest."""
ExecutionFactory = Callable[[Statistics, Budget, np.random.Generator], "Execution"]


class Execution:
    """Executes actions one after the other; it holds nothing that changes but statistics.

    A candidate is first rolled out alone, from its sweep on, which is cheap. If that is valid the
    whole motion is executed from the engine's exact state, so that what the search believes is
    what the continuous execution does (needs the capability exact_continuation). Other engines
    are asked last; each executes the plan in a line of its own, and ``tolerated`` of them may
    fail on the way.
    """

    def __init__(
        self,
        problem: Problem,
        arm: ArmModel,
        engines: Sequence[Engine],
        collision: CollisionChecker,
        arm_planner: ArmPlanner,
        contact_free: ContactFree,
        clear: Clear,
        statistics: Statistics,
        budget: Budget,
        tolerated: int = 0,
    ) -> None:
        """``engines``: the first one's state is what the search plans from."""
        self._contact_free, self._clear = contact_free, clear
        self._problem, self._arm = problem, arm
        self._collision, self._arm_planner = collision, arm_planner
        self._stats, self._budget = statistics, budget
        leading, *others = [Line(engine, problem.initial) for engine in engines]
        self.start = Stand(leading, tuple(others))
        """Where everything begins."""
        self._needed = len(others) - tolerated

    def after(
        self, stand: Stand, action: RearrangementAction, accept: Accept | None
    ) -> Stand | None:
        """Where the execution stands after the action.

        None if it is not valid, does not move its object, or does not pass ``accept``.
        """
        sweep = action.motion.after_transit()
        start = stand.state.with_joints(sweep.start)
        trial = self._rollout(replace(stand.leading, state=start, token=None), sweep, None)
        if not self._good(trial, action, accept):
            return None
        self._stats.counts["valid_rollouts"] += 1
        return self.executed(stand, action, accept)

    def executed(
        self, stand: Stand, action: RearrangementAction, accept: Accept | None
    ) -> Stand | None:
        """As ``after``, for an action that is expected to be valid: it is not tried alone."""
        whole = self._rollout(stand.leading, action.motion, _KEEP)
        if not self._good(whole, action, accept):
            self._stats.failed(action.object_name, action.kind, "not_reproduced")
            return None
        others = self._elsewhere(stand, action, accept)
        if others is None:
            return None
        self._stats.counts["accepted"] += 1
        return Stand(stand.leading.after(whole, action.motion), others)

    def _elsewhere(
        self, stand: Stand, action: RearrangementAction, accept: Accept | None
    ) -> tuple[Line, ...] | None:
        """The other engines' lines after the action; None if it fails in too many of them."""
        followed: list[Line] = []
        left = len(stand.others)
        for line, result in self._in_turn(stand.others, action.motion, _KEEP):
            left -= 1
            if self._good(result, action, accept) and self._free(line, result, action.motion):
                followed.append(line.after(result, action.motion))
            elif not self._enough(len(followed) + left):
                where = f"not_valid_in_{line.engine.name}"
                self._stats.failed(action.object_name, action.kind, where)
                return None
        return tuple(followed)

    def _in_turn(
        self, lines: Sequence[Line], motion: Motion, options: RolloutOptions | None
    ) -> Iterator[tuple[Line, RolloutResult]]:
        """Some at a time, as far as they share a model; what is not asked for is not run."""
        for _, group in groupby(
            lines, key=lambda line: (id(line.engine.model), line.engine.continuous)
        ):
            same = list(group)
            for start in range(0, len(same), _SIDE_BY_SIDE):
                some = same[start : start + _SIDE_BY_SIDE]
                yield from zip(some, self._batch(some, motion, options), strict=True)

    def _batch(
        self, lines: Sequence[Line], motion: Motion, options: RolloutOptions | None
    ) -> list[RolloutResult]:
        if len(lines) == 1:
            return [self._rollout(lines[0], motion, options)]
        jobs = [_job(line, motion) for line in lines]
        self._stats.counts["rollouts"] += len(lines)
        with self._stats.timed("rollouts"):
            results = lines[0].engine.model.rollout_batch(
                [state for state, _ in jobs],
                [executed for _, executed in jobs],
                parameters=[line.engine.parameters for line in lines],
                options=options if lines[0].engine.continuous else None,
                continue_from=[line.token for line in lines],
            )
        for result in results:
            self._charge(result)
        return results

    def _enough(self, engines: int) -> bool:
        return engines >= self._needed

    def _free(self, line: Line, result: RolloutResult, motion: Motion) -> bool:
        """Whether a way that was planned for the first engine's poses is free for these, too."""
        states = result.segment_states
        if not line.engine.continuous:
            before = len(motion.segments) - len(states)
            states = (*([line.state] * before), *states)
        return self._contact_free(motion, states)

    def retrieval_from(
        self, stand: Stand, retrieval: Motion, rng: np.random.Generator
    ) -> Motion | None:
        """The retrieval with a closed-gripper transit home in front, if the arm is elsewhere."""
        joints, home = stand.state.joint_positions, self._problem.home
        if np.abs(joints - home).max() < _HOME_TOLERANCE:
            return retrieval
        opening = self._arm.gripper.closed
        path = self._way(stand.state, home, opening, rng)
        if path is None:
            return None
        return Motion((self._transit(path, opening), *retrieval.segments), opening)

    def approached_anew(
        self, stand: Stand, motion: Motion, rng: np.random.Generator
    ) -> Motion | None:
        """``motion`` with a new transit to its first sweep; None if none is found."""
        sweep = motion.after_transit()
        path = self._way(stand.state, sweep.start, sweep.opening, rng)
        if path is None:
            return None
        return Motion((self._transit(path, sweep.opening), *sweep.segments), sweep.opening)

    def _way(
        self, state: SceneState, goal: Array, opening: float, rng: np.random.Generator
    ) -> Array | None:
        world = self._collision.world(state.object_poses, opening=opening)
        with self._stats.timed("arm_planning"):
            plan = self._arm_planner.plan(state.joint_positions, goal[None, :], world, rng)
        if plan.path is None:
            self._stats.failed("arm", "transit", str(plan.status))
        return plan.path

    def _transit(self, path: Array, opening: float) -> MotionSegment:
        timed = time_path(path, self._arm.velocity, scale=_TRANSIT_SPEED)
        return MotionSegment(SegmentKind.TRANSIT, timed, opening, contact_free=True)

    def keeps_clear(self, motion: Motion, state: SceneState, names: Collection[str]) -> bool:
        """Whether the arm, after its approach, stays away from some objects of ``state``."""
        sweep = motion.after_transit()
        others = {o.name for o in self._problem.scene.objects} - set(names)
        world = self._collision.world(state.object_poses, opening=sweep.opening, ignore=others)
        return all(world.free(s.trajectory.positions).all() for s in sweep.segments)

    def retrieved(self, stand: Stand, motion: Motion) -> tuple[RolloutResult, ...] | None:
        """What the leading engine did from the start to the end of the retrieval.

        None if the retrieval is not valid in the continuous execution, in enough engines.
        """
        result = self._rollout(stand.leading, motion, None)
        self._count_failures(result, "arm", "retrieval")
        if not result.valid or not self._holds_elsewhere(stand, motion):
            return None
        return (*stand.leading.executed, result)

    def _holds_elsewhere(self, stand: Stand, motion: Motion) -> bool:
        """Whether the retrieval is valid in enough of the other engines.

        Where nothing is near its way it need not be executed: from rest, masses and frictions only
        matter to what is touched.
        """
        doubtful = [
            line
            for line in stand.others
            if line.engine.continuous or not self._clear(motion, line.state)
        ]
        holding, left = len(stand.others) - len(doubtful), len(doubtful)
        for line, result in self._in_turn(doubtful, motion, None):
            left -= 1
            self._count_failures(result, "arm", "retrieval")
            if result.valid and self._free(line, result, motion):
                holding += 1
            elif not self._enough(holding + left):
                self._stats.failed("arm", "retrieval", f"not_valid_in_{line.engine.name}")
                return False
        return True

    def _good(
        self, result: RolloutResult, action: RearrangementAction, accept: Accept | None
    ) -> bool:
        cause = next(self._faults(result, action, accept), None)
        if cause is not None:
            self._stats.failed(action.object_name, action.kind, cause)
        return cause is None

    def _faults(
        self, result: RolloutResult, action: RearrangementAction, accept: Accept | None
    ) -> Iterator[str]:
        yield from _broken(result)
        if action.object_name not in result.moved:
            yield "unmoved"
        end = action.motion.end
        world = self._collision.world(
            result.final_state.object_poses, opening=action.motion.segments[-1].opening
        )
        if not world.free(end)[0]:
            yield "arm_blocked_after"
        if accept is not None and not accept(result.final_state):
            yield "no_gain"

    def _count_failures(self, result: RolloutResult, subject: str, action: str) -> None:
        for cause in _broken(result):
            self._stats.failed(subject, action, cause)

    def _rollout(self, line: Line, motion: Motion, options: RolloutOptions | None) -> RolloutResult:
        state, executed = _job(line, motion)
        self._stats.counts["rollouts"] += 1
        with self._stats.timed("rollouts"):
            result = line.engine.model.rollout(
                state,
                executed,
                parameters=line.engine.parameters,
                options=options,
                continue_from=line.token,
            )
        self._charge(result)
        return result

    def _charge(self, result: RolloutResult) -> None:
        self._stats.charge("rollouts", result.outside_cpu)
        self._budget.charge(result.outside_cpu)


def _job(line: Line, motion: Motion) -> tuple[SceneState, Motion]:
    """What an engine executes, and from where."""
    if line.engine.continuous:
        return line.state, motion
    sweep = motion.after_transit()
    return line.state.with_joints(sweep.start), sweep


def _broken(result: RolloutResult) -> Iterator[str]:
    """Why a rollout is not valid; of its violations the first."""
    if result.lost is not None:
        yield result.lost
    if result.stalled:
        yield "stalled"
    for violation in result.violations[:1]:
        yield violation.constraint
