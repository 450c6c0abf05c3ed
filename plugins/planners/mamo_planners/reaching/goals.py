"""Configurations at a pre-grasp that fixtures and immovables leave free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionChecker, CollisionWorld
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array
from mamo_core.types.problem import Problem, Task
from mamo_core.types.scene import Mobility, SceneState
from mamo_planners.grasp_candidates import Candidate, GraspCandidates
from mamo_planners.options import RetrievalOptions

_BRANCHES, _THOROUGH = 8, 20


@dataclass(frozen=True, eq=False)
class Goal:
    """A ``configuration`` (dof,) at a pre-grasp; ``candidate``: how a retrieval goes on there."""

    configuration: Array
    candidate: Candidate | None = None


class Goals:
    """Where the arm may end in one problem; the hand opens as the first usable grasp wants it.

    ``opening``: gap between the fingers, m. ``tools`` (k, 4, 4): world poses of the tool there;
    none if no pre-grasp can be taken up even without movables.
    """

    def __init__(
        self,
        problem: Problem,
        arm: ArmModel,
        kinematics: Kinematics,
        collision: CollisionChecker,
        rng: np.random.Generator,
    ) -> None:
        self._problem, self._kinematics, self._collision = problem, kinematics, collision
        objects = problem.scene.objects
        self._movables = [o.name for o in objects if o.mobility is Mobility.MOVABLE]
        self.opening = arm.gripper.max_opening
        if problem.task is Task.RETRIEVE:
            found = GraspCandidates(problem, arm, kinematics, collision, RetrievalOptions()).found
            self._fixed = self._of_retrievals(found)
        else:
            # Tight places leave few arm configurations: look harder before saying there are none.
            tries = (_BRANCHES, _THOROUGH * _BRANCHES)
            self._fixed = next(filter(None, (self._of_reaches(n, rng) for n in tries)), [])
        tools = [kinematics.forward(goal.configuration) for goal in self._fixed]
        self.tools = np.array(tools).reshape(-1, 4, 4)

    @property
    def known(self) -> tuple[Goal, ...]:
        """Those that are computed once, at least one for each usable pre-grasp."""
        return tuple(self._fixed)

    def without_movables(self) -> CollisionWorld:
        """What must not be touched: Phase 1 of thesis 3.3.2."""
        poses = self._problem.initial.object_poses
        return self._collision.world(poses, opening=self.opening, ignore=self._movables)

    def with_everything(self, state: SceneState) -> CollisionWorld:
        """All objects as they stand: what is free here needs no simulation."""
        return self._collision.world(state.object_poses, opening=self.opening)

    def near(self, q: Array, rng: np.random.Generator) -> Goal:
        """A goal close to a configuration (dof,): computed from there, or the nearest known."""
        nearest = min(self._fixed, key=lambda goal: float(np.abs(goal.configuration - q).max()))
        if nearest.candidate is not None:
            return nearest
        T = self._kinematics.forward(nearest.configuration)
        found = self._kinematics.inverse(T, rng, count=1, near=q)
        free = found[self.without_movables().free(found)] if len(found) else found
        return Goal(free[0]) if len(free) else nearest

    def drawn(self, rng: np.random.Generator) -> Goal:
        """A random goal, computed anew where the task allows it."""
        goal = self._fixed[int(rng.integers(len(self._fixed)))]
        if goal.candidate is not None:
            return goal
        T = self._kinematics.forward(goal.configuration)
        found = self._kinematics.inverse(T, rng, count=1)
        free = found[self.without_movables().free(found)] if len(found) else found
        return Goal(free[0]) if len(free) else goal

    def _of_retrievals(self, candidates: list[Candidate]) -> list[Goal]:
        if not candidates:
            return []
        self.opening = candidates[0].grasp.opening
        same = [c for c in candidates if c.grasp.opening == self.opening]
        return [Goal(c.reach[0], c) for c in same]

    def _of_reaches(self, branches: int, rng: np.random.Generator) -> list[Goal]:
        goals: list[Goal] = []
        for grasp, T in zip(self._problem.grasps, self._problem.pregrasps, strict=True):
            if goals and grasp.opening != self.opening:
                continue
            found = self._kinematics.inverse(T, rng, count=branches)
            self.opening = grasp.opening if not goals else self.opening
            free = found[self.without_movables().free(found)] if len(found) else found
            goals += [Goal(q) for q in free]
        return goals
