"""Retrieval: open at home, reach, lift as far as the shelf allows, carry home."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection

import numpy as np

from mamo_core.interfaces.arm_planner import ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionChecker, HeldObject
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.interfaces.retrieval import Retrieval, RetrievalPlanner
from mamo_core.robots.model import ArmModel
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility, SceneState
from mamo_planners.grasp_candidates import Candidate, GraspCandidates
from mamo_planners.ignoring import IgnoringChecker
from mamo_planners.options import RetrievalOptions
from mamo_planners.retrieval_motion import RetrievalMotion


class GraspAndExtract(RetrievalPlanner):
    """Grasps that can be reached are found once per problem; what stands in the way, per call."""

    def __init__(
        self,
        problem: Problem,
        arm: ArmModel,
        kinematics: Kinematics,
        collision: CollisionChecker,
        arm_planner: ArmPlanner,
        options: RetrievalOptions,
        patient: bool = True,
    ) -> None:
        """``patient``: look much harder before saying that no grasp works."""
        self._problem, self._arm = problem, arm
        self._kinematics, self._collision, self._arm_planner = kinematics, collision, arm_planner
        self._options = options
        scene = problem.scene
        self._target = scene.objects[scene.target_index]
        self._movables = [o.name for o in scene.objects if o.mobility is Mobility.MOVABLE]
        self._grasps = GraspCandidates(problem, arm, kinematics, collision, options, patient)
        self._motion = RetrievalMotion(problem, arm, kinematics, options)

    def plan(
        self,
        state: SceneState,
        rng: np.random.Generator,
        *,
        ignore_movables: bool = False,
        avoid: Collection[int] = (),
    ) -> Retrieval:
        causes = Counter(self._grasps.causes)
        ignored = self._movables if ignore_movables else []
        allowed = [c for c in self._grasps.found if c.number not in avoid]
        usable = allowed if ignore_movables else self._unblocked(state, allowed)
        causes["grasp_blocked"] += len(allowed) - len(usable)
        order = rng.permutation(len(usable))
        pending = [usable[i] for i in order]
        for _ in range(self._options.tries):
            if not pending:
                break
            motion, used = self._try(state, ignored, pending, rng, causes)
            if motion is not None:
                return Retrieval(motion, used[0].number)
            pending = [c for c in pending if c not in used]
        return Retrieval(None, causes=+causes)

    def swept_region(self, state: SceneState, motion: Motion) -> SweptRegion:
        region: SweptRegion | None = None
        for segment in motion.segments:
            held = None
            if segment.held is not None:
                held = self._held_of(motion)
            part = self._collision.swept_region(
                segment.trajectory.positions, opening=segment.opening, held=held
            )
            region = part if region is None else region.united(part)
        if region is None:
            raise ValueError("swept_region: the motion has no segments")
        return region

    def thorough(self) -> RetrievalPlanner:
        options = self._options
        if options.grasps >= len(self._problem.grasps):
            return self
        more = {"grasps": len(self._problem.grasps), "branches": 2 * options.branches}
        return GraspAndExtract(
            self._problem,
            self._arm,
            self._kinematics,
            self._collision,
            self._arm_planner,
            options.model_copy(update=more),
        )

    def without(self, names: Collection[str]) -> RetrievalPlanner:
        return GraspAndExtract(
            self._problem,
            self._arm,
            self._kinematics,
            IgnoringChecker(self._collision, names),
            self._arm_planner,
            self._options,
            patient=False,
        )

    def _held_of(self, motion: Motion) -> HeldObject:
        """The target in the tool, from where the tool is when it is attached."""
        first = next(s for s in motion.segments if s.held is not None)
        return self._grasps.held_at(self._kinematics.forward(first.trajectory.positions[0]))

    def _unblocked(self, state: SceneState, candidates: list[Candidate]) -> list[Candidate]:
        """Candidates whose reach and lifted pose are free among the objects of ``state``."""
        openings = np.array([candidate.grasp.opening for candidate in candidates])
        clear = np.ones(len(candidates), dtype=np.bool_)
        for opening in set(openings.tolist()):
            same = np.flatnonzero(openings == opening)
            world, close = self._grasps.worlds(state.object_poses, opening, [])
            for one, ways in (
                (world, [np.stack([candidates[k].reach[0], candidates[k].lift[-1]]) for k in same]),
                (close, [candidates[k].reach for k in same]),
            ):
                starts = np.cumsum([0, *(len(way) for way in ways[:-1])])
                free = np.logical_and.reduceat(one.free(np.concatenate(ways)), starts)
                clear[same] &= free
        return [candidates[k] for k in np.flatnonzero(clear)]

    def _try(
        self,
        state: SceneState,
        ignored: list[str],
        pending: list[Candidate],
        rng: np.random.Generator,
        causes: Counter[str],
    ) -> tuple[Motion | None, list[Candidate]]:
        """One multi-goal query over the candidates that share an opening, then the carry."""
        opening = pending[0].grasp.opening
        group = [c for c in pending if c.grasp.opening == opening]
        world = self._collision.world(state.object_poses, opening=opening, ignore=ignored)
        goals = np.array([c.reach[0] for c in group])
        reach = self._arm_planner.plan(self._problem.home, goals, world, rng)
        if reach.path is None:
            causes[f"transit_{reach.status}"] += 1
            return None, group
        chosen = group[reach.goal]
        carry_world = self._collision.world(
            state.object_poses,
            opening=chosen.width,
            ignore=[self._target.name, *ignored],
            held=chosen.held,
        )
        carry = self._arm_planner.plan(
            chosen.lift[-1], self._problem.home[None, :], carry_world, rng
        )
        if carry.path is None:
            causes[f"carry_{carry.status}"] += 1
            return None, [chosen]
        return self._motion.whole(chosen, reach.path, carry.path), [chosen]
