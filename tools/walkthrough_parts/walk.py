"""One problem planned while watching, and what every candidate that was offered would have done."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mamo_core.compose import Planner, compose
from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.plugins import discover
from mamo_core.recipe_sets import chosen_recipe
from mamo_core.recording import record
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array
from mamo_core.types.motion import SegmentKind
from mamo_core.types.problem import Problem
from mamo_core.types.recording import Recording
from mamo_core.types.region import SweptRegion
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Plan, Statistics
from walkthrough_parts.watched import Notes, Offer, watched

RECIPE = "m4m"
BUDGET = 60.0


@dataclass(frozen=True, eq=False)
class Trial:
    """A candidate and what happens.

    ``tool``: its way (k, 2) while it sweeps, m; ``pointing`` (2,): where the hand points before.
    """

    action: RearrangementAction
    tool: Array
    pointing: Array
    result: RolloutResult

    @property
    def holds(self) -> bool:
        """No constraint is broken, and the object moved."""
        return self.result.valid and self.action.object_name in self.result.moved

    @property
    def fault(self) -> str:
        """In words, empty if it holds."""
        if self.holds:
            return ""
        if self.result.violations:
            return str(self.result.violations[0])
        return "stalled" if self.result.stalled else "unmoved"


@dataclass(frozen=True, eq=False)
class Walk:
    """How a plan came about; ``states`` after each of its actions, the first before all.

    ``drawn``: how many NGRs the search drew; ``swept``: the region of the retrieval it found.
    """

    problem: Problem
    plan: Plan
    statistics: Statistics
    notes: Notes
    states: tuple[SceneState, ...]
    recording: Recording
    planner: Planner
    drawn: int
    swept: SweptRegion

    @property
    def region(self) -> SweptRegion:
        """The NGR that was taken, of those drawn."""
        assert self.plan.region is not None
        return self.plan.region

    def in_the_way(self, number: int) -> list[str]:
        """Names of the movables inside the NGR in one of the states."""
        scene, region = self.problem.scene, self.region
        poses = self.states[number].object_poses
        return [
            scene.objects[i].name
            for i in scene.movable_indices
            if region.overlaps(scene.objects[i].shape, poses[i])
        ]

    def trials(self, offer: Offer) -> tuple[Trial, ...]:
        """What each candidate of an offer does from where the scene stands."""
        return tuple(_trial(self.planner, offer.state, action) for action in offer.candidates)


def walk(problem: Problem, seed: int = 0) -> Walk:
    """Plan, and keep everything.

    Raises:
        ValueError: no plan was found.
    """
    notes = Notes()
    planner = compose(chosen_recipe(RECIPE), problem, watched(discover(), notes))
    solution = planner.solve(BUDGET, seed)
    if solution.plan is None:
        raise ValueError(f"{problem.name}: {solution.reason}")
    plan, context, drawn = solution.plan, planner.context, len(notes.regions)
    recording = record(problem, plan, {"engine": context.part("backend")}, context.robot)
    states = _states(recording, len(plan.actions))
    swept = context.part("retrieval").swept_region(states[-1], plan.retrieval)
    return Walk(problem, plan, solution.statistics, notes, states, recording, planner, drawn, swept)


def _states(recording: Recording, actions: int) -> tuple[SceneState, ...]:
    execution = recording.executions[0]
    ends = [
        max(stretch.last for stretch in recording.stretches if stretch.motion == number)
        for number in range(actions)
    ]
    return tuple(SceneState(execution.joints[row], execution.poses[row]) for row in (0, *ends))


def _trial(planner: Planner, state: SceneState, action: RearrangementAction) -> Trial:
    motion = action.motion.after_transit()
    result = planner.context.part("backend").rollout(
        state.with_joints(motion.start), motion, options=RolloutOptions(trace_step=0.02)
    )
    sweeps = [s for s in motion.segments if s.kind is SegmentKind.SWEEP]
    kinematics = planner.context.part("kinematics")
    joints = np.concatenate([segment.trajectory.positions for segment in sweeps])
    poses = np.array([kinematics.forward(q) for q in joints])
    return Trial(action, poses[:, :2, 3], poses[0, :2, 0], result)
