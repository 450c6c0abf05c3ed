"""The search: retrieve the target, or move one more object out of the way, depth-first.

To make it yours, begin with ``_Descent._steps``, which says what is tried next and in which order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from mamo_core.hookspecs import Options
from mamo_core.interfaces.action_generator import ActionGenerator, ActionRequest
from mamo_core.interfaces.arm_planner import ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.interfaces.retrieval import RetrievalPlanner
from mamo_core.interfaces.search_strategy import ProgressCallback, SearchStrategy
from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import time_path
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Budget, Plan, Solution, SolutionStatus, Statistics

if TYPE_CHECKING:
    from mamo_core.verify import VerifyReport

_DIRECTIONS, _STEP, _FARTHEST = 16, 0.02, 0.4
"""Ways out of the region that are looked at: their number, and lengths, m."""

Actions = tuple[RearrangementAction, ...]


class MySearchOptions(Options):
    """What a recipe may set: ``{name: my_search, depth: 4}``."""

    depth: int = Field(default=6, ge=0, description="largest number of actions in a plan")
    branching: int = Field(default=2, ge=1, description="actions of a kind to try for each way")
    attempts: int = Field(default=20, ge=1, description="searches with new random numbers")
    speed: float = Field(default=0.5, gt=0.0, le=1.0, description="of the way home, fraction")


@dataclass(frozen=True, eq=False)
class MySearch(SearchStrategy):
    """Depth-first searches until one ends in a verified plan."""

    problem: Problem
    robot: ArmModel
    backend: TransitionModel
    collision: CollisionChecker
    arm_planner: ArmPlanner
    retrieval: RetrievalPlanner
    actions: tuple[tuple[str, ActionGenerator], ...]
    verifier: Callable[[Plan], VerifyReport]
    options: MySearchOptions

    def solve(
        self, budget: Budget, rng: np.random.Generator, progress: ProgressCallback
    ) -> Solution:
        """A verified plan, or why there is none."""
        statistics = Statistics()
        for attempt in range(self.options.attempts):
            if budget.exhausted:
                break
            progress(f"attempt {attempt + 1}")
            plan = _Descent(self, budget, rng, statistics).solve()
            if plan is not None:
                return Solution(SolutionStatus.SOLVED, plan, statistics)
        why = "no plan within the budget" if budget.exhausted else "nothing is left to try"
        return Solution(SolutionStatus.BUDGET_EXHAUSTED, None, statistics, why)


@dataclass(frozen=True, eq=False)
class _Descent:
    """One depth-first search from the initial state."""

    parts: MySearch
    budget: Budget
    rng: np.random.Generator
    statistics: Statistics

    def solve(self) -> Plan | None:
        start = self.parts.problem.initial
        # What the retrieval would sweep if there were no movables: they have to leave it.
        found = self.parts.retrieval.plan(start, self.rng, ignore_movables=True)
        if found.motion is None:
            self._count_retrieval(found.causes)
            return None
        return self._from(start, (), self.parts.retrieval.swept_region(start, found.motion))

    def _from(self, state: SceneState, done: Actions, region: SweptRegion) -> Plan | None:
        """A plan that begins with the actions in ``done``, which led to ``state``."""
        plan = self._retrieve(state, done, region)
        if plan is not None or len(done) == self.parts.options.depth:
            return plan
        for action, after in self._steps(state, region):
            plan = self._from(after, (*done, action), region)
            if plan is not None:
                return plan
        return None

    def _steps(
        self, state: SceneState, region: SweptRegion
    ) -> Iterator[tuple[RearrangementAction, SceneState]]:
        """Valid actions, in the order they are tried, and where they lead: EDIT HERE.

        The object that takes the most room in the region comes first, then its shortest ways out.
        """
        before = self._overlaps(state, region)
        for name in sorted(before, key=lambda name: -before[name]):
            for way in self._ways_out(state, name, region):
                for action in self._proposed(state, ActionRequest(name, way, region)):
                    after = self._simulated(state, action)
                    if after is None:
                        continue
                    if sum(self._overlaps(after, region).values()) < sum(before.values()):
                        yield action, after
                    else:
                        self.statistics.failed(name, action.kind, "no_gain")

    def _ways_out(self, state: SceneState, name: str, region: SweptRegion) -> list[Array]:
        """Straight paths (2, 2) of an object out of the region, the shortest first."""
        scene = self.parts.problem.scene
        place = scene.index(name)
        lower, upper = scene.workspace.lower[:2], scene.workspace.upper[:2]
        ways = []
        for angle in np.linspace(-np.pi, np.pi, _DIRECTIONS, endpoint=False):
            for length in np.arange(_STEP, _FARTHEST, _STEP):
                pose = np.array(state.object_poses[place])
                pose[:2] += length * np.array([np.cos(angle), np.sin(angle)])
                if (pose[:2] < lower).any() or (pose[:2] > upper).any():
                    break
                if not region.overlaps(scene.objects[place].shape, pose):
                    ways.append((length, np.stack([state.object_poses[place, :2], pose[:2]])))
                    break
        return [way for _, way in sorted(ways, key=lambda pair: pair[0])]

    def _proposed(self, state: SceneState, request: ActionRequest) -> Iterator[RearrangementAction]:
        """A few actions of each kind, computed when asked for, while there is time."""
        for _, generator in self.parts.actions:
            proposals = generator.propose(state, request, self.rng, self.statistics)
            for action in islice(proposals, self.parts.options.branching):
                if self.budget.exhausted:
                    return
                yield action

    def _overlaps(self, state: SceneState, region: SweptRegion) -> dict[str, float]:
        """Area (m^2) that each movable takes in the region, without those outside of it."""
        scene = self.parts.problem.scene
        areas = {
            scene.objects[i].name: region.overlap(scene.objects[i].shape, state.object_poses[i])
            for i in scene.movable_indices
        }
        return {name: area for name, area in areas.items() if area > 0.0}

    def _simulated(self, state: SceneState, action: RearrangementAction) -> SceneState | None:
        """Where the action leads, if it is valid."""
        with self.statistics.timed("simulation"):
            result = self.parts.backend.rollout(state, action.motion)
        self.statistics.counts["rollouts"] += 1
        self.budget.charge(result.outside_cpu)
        if result.valid:
            # The next motion starts where this one was told to end; servos are never quite there.
            return result.final_state.with_joints(action.motion.end)
        self.statistics.failed(action.object_name, action.kind, _cause(result))
        return None

    def _retrieve(self, state: SceneState, done: Actions, region: SweptRegion) -> Plan | None:
        """The finished plan, if the target can be taken out now and all of it is verified."""
        with self.statistics.timed("retrieval"):
            found = self.parts.retrieval.plan(state, self.rng)
        if found.motion is None:
            self._count_retrieval(found.causes)
            return None
        way = self._way_home(state)
        if way is None:
            self.statistics.failed("arm", "way_home", "no_path")
            return None
        motion = Motion((*way, *found.motion.segments), found.motion.opening)
        plan = Plan(done, motion, region)
        with self.statistics.timed("verification"):
            report = self.parts.verifier(plan)
        self.budget.charge(report.outside_cpu)
        for failure in report.failures:
            self.statistics.failed("plan", "verification", failure)
        return plan if report.ok else None

    def _way_home(self, state: SceneState) -> tuple[MotionSegment, ...] | None:
        """From where the arm is to where retrievals start; None if there is no way."""
        parts, here, home = self.parts, state.joint_positions, self.parts.problem.home
        if np.abs(here - home).max() < 1e-6:
            return ()
        closed = parts.robot.gripper.closed
        world = parts.collision.world(state.object_poses, opening=closed)
        path = parts.arm_planner.plan(here, home[None], world, self.rng).path
        if path is None:
            return None
        timed = time_path(path, parts.robot.limits, scale=parts.options.speed)
        return (MotionSegment(SegmentKind.TRANSIT, timed, closed, contact_free=True),)

    def _count_retrieval(self, causes: Mapping[str, int]) -> None:
        scene = self.parts.problem.scene
        for cause, times in causes.items():
            name = scene.objects[scene.target_index].name
            self.statistics.failed(name, "retrieval", cause, times)


def _cause(result: RolloutResult) -> str:
    """Why a rollout is not valid, in a word."""
    if result.lost is not None:
        return result.lost
    return result.violations[0].constraint if result.violations else "stalled"
