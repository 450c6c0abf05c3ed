"""The continuous execution: candidates are tried from where it really stands."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

import numpy as np

from mamo_core.interfaces.arm_planner import ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.interfaces.transition_model import Replay
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import time_path
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Budget, Statistics
from mamo_planners.search.followers import Clear, ContactFree, Samples, Witnesses, split
from mamo_planners.search.judging import Accept, Judge
from mamo_planners.search.neighbours import Neighbours, Passes
from mamo_planners.search.rollouts import KEEP, Rollouts
from mamo_planners.search.safety import SafetyMargin
from mamo_planners.search.stand import Engine, Line, Stand

_TRANSIT_SPEED = 0.5
_HOME_TOLERANCE = 1e-6

ExecutionFactory = Callable[[Statistics, Budget, np.random.Generator], "Execution"]


class Execution:
    """Executes actions one after the other; it holds nothing that changes but statistics.

    A candidate is first tried alone, from its sweep on, which is cheap. If that is valid the whole
    motion is executed from the engine's exact state, so that what the search believes is what the
    continuous execution does (needs the capability exact_continuation). The other engines follow,
    each in a line of its own: samples, of which ``tolerated`` may fail, and neighbours before the
    whole motion, continuous ones after it.
    """

    def __init__(
        self,
        problem: Problem,
        arm: ArmModel,
        trial: Engine,
        engines: Sequence[Engine],
        nearby: Sequence[Replay],
        collision: CollisionChecker,
        arm_planner: ArmPlanner,
        contact_free: ContactFree,
        clear: Clear,
        passes: Passes,
        statistics: Statistics,
        budget: Budget,
        tolerated: int = 0,
        safety_margin: float = 0.0,
    ) -> None:
        """``trial``: tries candidates, not continuously; ``engines``: the first one's state is what
        the search plans from; ``nearby``: worlds in which everything must hold, too."""
        self._problem, self._arm, self._trial = problem, arm, trial
        self._collision, self._arm_planner = collision, arm_planner
        self._stats = statistics
        leading, *others = [Line(engine, problem.initial) for engine in engines]
        others += [_line_of(replay) for replay in nearby]
        self.start = Stand(leading, tuple(others))
        """Where everything begins."""
        self._rollouts = Rollouts(statistics, budget)
        self._judge = Judge(collision, SafetyMargin(problem, safety_margin), statistics)
        needed = len(split(others).samples) - tolerated
        asks = self._rollouts, self._judge, statistics
        self._samples = Samples(collision, contact_free, clear, *asks, needed)
        self._witnesses = Witnesses(contact_free, *asks)
        self._neighbours = Neighbours(passes, *asks)

    def after(
        self, stand: Stand, action: RearrangementAction, accept: Accept | None
    ) -> Stand | None:
        """Where the execution stands after the action.

        None if it is not valid, does not move its object, or does not pass ``accept``.
        """
        trial = self._rollouts.one(Line(self._trial, stand.state), action.motion, None)
        if not self._judge.good(trial, action, accept):
            return None
        self._stats.counts["valid_rollouts"] += 1
        followed = self._followed(stand, action, accept, trial.final_state)
        if followed is None:
            return None
        leading = self._whole(stand, action, accept)
        return self._agreed(stand, action, accept, leading, followed) if leading else None

    def executed(
        self, stand: Stand, action: RearrangementAction, accept: Accept | None
    ) -> Stand | None:
        """As ``after``, for an action that is expected to be valid: it is not tried alone."""
        leading = self._whole(stand, action, accept)
        if leading is None:
            return None
        followed = self._followed(stand, action, accept, leading.state)
        return (
            self._agreed(stand, action, accept, leading, followed) if followed is not None else None
        )

    def _followed(
        self,
        stand: Stand,
        action: RearrangementAction,
        accept: Accept | None,
        expected: SceneState,
    ) -> tuple[Line, ...] | None:
        """Samples and neighbours after the action; None if it does not hold in them."""
        followers = split(stand.others)
        samples = self._samples.follow(followers.samples, action, accept, expected)
        if samples is None:
            return None
        neighbours = self._neighbours.follow(followers.neighbours, action)
        return None if neighbours is None else (*samples, *neighbours)

    def _whole(
        self, stand: Stand, action: RearrangementAction, accept: Accept | None
    ) -> Line | None:
        """The leading line after the action."""
        result = self._rollouts.one(stand.leading, action.motion, KEEP)
        if not self._judge.good(result, action, accept):
            self._stats.failed(action.object_name, action.kind, "not_reproduced")
            return None
        return stand.leading.after(result, action.motion)

    def _agreed(
        self,
        stand: Stand,
        action: RearrangementAction,
        accept: Accept | None,
        leading: Line,
        followed: tuple[Line, ...],
    ) -> Stand | None:
        """The stand after the action, if all other engines agree."""
        witnesses = self._witnesses.follow(split(stand.others).continuous, action, accept)
        if witnesses is None:
            return None
        self._stats.counts["accepted"] += 1
        self._stats.succeeded(action.object_name, action.kind)
        return Stand(leading, (*followed, *witnesses))

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
        timed = time_path(path, self._arm.limits, scale=_TRANSIT_SPEED)
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
        samples, neighbours, continuous = split(stand.others)
        if not self._samples.hold(samples, motion):
            return None
        result = self._rollouts.one(stand.leading, motion, None)
        if not (self._judge.retrieved(result) and self._neighbours.hold(neighbours, motion)):
            return None
        if not self._witnesses.hold(continuous, motion):
            return None
        return (*stand.leading.executed, result)


def _line_of(replay: Replay) -> Line:
    engine = Engine(replay.name, replay.model, continuous=False, nearby=True)
    return Line(engine, replay.start)
