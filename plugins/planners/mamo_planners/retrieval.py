"""Retrieval: open at home, reach, lift as far as the shelf allows, carry home."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection

import numpy as np

from mamo_core.interfaces.arm_planner import ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionChecker, HeldObject
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.interfaces.retrieval import Retrieval, RetrievalPlanner
from mamo_core.robots.grasps import widths_between_fingers
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import interpolated, time_path
from mamo_core.types.geometry import Array, matrix_from_pose
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.problem import Grasp, Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility, SceneState
from mamo_planners.grasp_candidates import Candidate, GraspCandidates
from mamo_planners.options import RetrievalOptions

_GRIPPER_TIME = 0.5
_TOOL_SPEED_STEP = 0.1
_ROOMY, _SLOWEST = 0.004, 0.3
"""Beside the target, m, from which the hand goes at full speed, and the least share of it."""


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
    ) -> None:
        self._problem, self._arm = problem, arm
        self._kinematics, self._collision, self._arm_planner = kinematics, collision, arm_planner
        self._options = options
        scene = problem.scene
        self._target = scene.objects[scene.target_index]
        self._movables = [o.name for o in scene.objects if o.mobility is Mobility.MOVABLE]
        self._grasps = GraspCandidates(problem, arm, kinematics, collision, options)

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
            opening=opening,
            ignore=[self._target.name, *ignored],
            held=chosen.held,
        )
        carry = self._arm_planner.plan(
            chosen.lift[-1], self._problem.home[None, :], carry_world, rng
        )
        if carry.path is None:
            causes[f"carry_{carry.status}"] += 1
            return None, [chosen]
        return self._motion(chosen, reach.path, carry.path), [chosen]

    def _motion(self, chosen: Candidate, transit: Array, carry: Array) -> Motion:
        options, opening, name = self._options, chosen.grasp.opening, self._target.name
        home = np.stack([self._problem.home, self._problem.home])
        return Motion(
            (
                MotionSegment(
                    SegmentKind.GRIPPER,
                    Trajectory(np.array([0.0, _GRIPPER_TIME]), home),
                    opening,
                    contact_free=True,
                ),
                MotionSegment(
                    SegmentKind.TRANSIT, self._timed(transit, np.inf), opening, contact_free=True
                ),
                MotionSegment(
                    SegmentKind.REACH,
                    self._timed(chosen.reach, self._reach_speed(chosen.grasp)),
                    opening,
                    contact_free=True,
                ),
                MotionSegment(
                    SegmentKind.LIFT,
                    self._timed(chosen.lift, options.reach_speed),
                    opening,
                    held=name,
                    contact_free=True,
                ),
                MotionSegment(
                    SegmentKind.CARRY,
                    self._timed(carry, options.carry_speed, chosen.held.T_tool_object),
                    opening,
                    held=name,
                    contact_free=True,
                ),
            ),
            self._arm.gripper.closed,
        )

    def _reach_speed(self, grasp: Grasp) -> float:
        """Slower where the target nearly fills the hand: servos stray more the faster they go."""
        T_object_tool = matrix_from_pose(grasp.T_object_tool)
        width = widths_between_fingers(self._target.shape, T_object_tool[None])[0]
        gap = (grasp.opening - width) / 2.0
        return self._options.reach_speed * float(np.clip(gap / _ROOMY, _SLOWEST, 1.0))

    def _timed(self, path: Array, speed: float, T_tool_point: Array | None = None) -> Trajectory:
        """No faster than ``speed`` (m/s) at the tool, or at a point of it."""
        if np.isfinite(speed):
            path = interpolated(path, _TOOL_SPEED_STEP)
        T = np.eye(4) if T_tool_point is None else T_tool_point
        return time_path(
            path,
            self._arm.velocity,
            scale=self._options.joint_speed,
            tool_positions=np.array([(self._kinematics.forward(q) @ T)[:3, 3] for q in path]),
            tool_speed=speed,
        )
