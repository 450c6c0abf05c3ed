"""Retrieval: open at home, reach, lift as far as the shelf allows, carry home."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from mamo_core.interfaces.arm_planner import ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionChecker, CollisionWorld, HeldObject
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.interfaces.retrieval import Retrieval, RetrievalPlanner
from mamo_core.robots.exact_collision import ExactChecker
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import interpolated, time_path
from mamo_core.types.geometry import Array, Box, invert, matrices_from_poses, matrix_from_pose
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.problem import Grasp, Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility, SceneState
from mamo_planners.options import RetrievalOptions

_GRIPPER_TIME = 0.5
_LEAST_LIFT = 0.003
_CANDIDATE_SEED = 0
_THOROUGH = 20
_AT_ONCE = 16
_REACH_STEP = 0.01
_APPROACH_SHARES = (1.0, 0.65, 0.45, 0.3)
_TOOL_SPEED_STEP = 0.1
_ROOMY, _SLOWEST = 0.004, 0.3
"""Beside the target, m, from which the hand goes at full speed, and the least share of it."""


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A grasp the arm can reach past fixtures and immovables: ``reach`` and ``lift`` (k, dof)."""

    number: int
    grasp: Grasp
    reach: Array
    lift: Array
    held: HeldObject


class GraspAndExtract(RetrievalPlanner):
    """Grasp candidates depend on nothing that moves, so they are computed once per problem."""

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
        self._T_world_target = matrix_from_pose(problem.initial.object_poses[scene.target_index])
        self._root, self._length = _outstretched(problem, arm)
        self._static_causes: Counter[str] = Counter()
        self._close = collision
        """Checks the way in to the target."""
        # Tight places leave few arm configurations: look harder before saying there are none.
        self._candidates = self._find_candidates(options.branches) or self._find_candidates(
            _THOROUGH * options.branches
        )
        if not self._candidates:
            # The covers leave no way; the meshes, which have the last word anyhow, may leave one.
            self._close = ExactChecker(scene, arm)
            self._candidates = self._find_candidates(_THOROUGH * options.branches)

    def plan(
        self,
        state: SceneState,
        rng: np.random.Generator,
        *,
        ignore_movables: bool = False,
        avoid: Collection[int] = (),
    ) -> Retrieval:
        causes = Counter(self._static_causes)
        ignored = self._movables if ignore_movables else []
        allowed = [c for c in self._candidates if c.number not in avoid]
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
        return self._held_at(self._kinematics.forward(first.trajectory.positions[0]))

    def _find_candidates(self, branches: int) -> list[_Candidate]:
        """Grasps are looked at in the problem's order until enough of them work."""
        self._static_causes.clear()
        rng = np.random.default_rng(_CANDIDATE_SEED)
        found: list[_Candidate] = []
        for start in range(0, len(self._problem.grasps), _AT_ONCE):
            numbers = range(start, min(start + _AT_ONCE, len(self._problem.grasps)))
            for opening, some in self._by_opening(numbers).items():
                poses, ignored = self._problem.initial.object_poses, self._movables
                world, close = self._worlds(poses, opening, ignored)
                for number, T_grasp in self._screened(some, world):
                    found += self._candidates_of(number, T_grasp, world, close, branches, rng)
            if len({candidate.number for candidate in found}) >= self._options.grasps:
                break
        return found

    def _candidates_of(
        self,
        number: int,
        T_grasp: Array,
        world: CollisionWorld,
        close: CollisionWorld,
        branches: int,
        rng: np.random.Generator,
    ) -> list[_Candidate]:
        """The ways in and up for one grasp."""
        solutions = self._kinematics.inverse(T_grasp, rng, count=branches)
        if not len(solutions):
            self._static_causes["grasp_no_ik"] += 1
            return []
        free = close.free(solutions)
        self._static_causes["grasp_in_collision"] += int((~free).sum())
        ways = [(q, self._back_path(q, number, world, close)) for q in solutions[free]]
        open_ways = [(q, back) for q, back in ways if back is not None]
        self._static_causes["reach_blocked"] += len(ways) - len(open_ways)
        if not open_ways:
            return []
        held = self._held_at(T_grasp)
        carried = self._carried(number, held)
        if not carried.free(self._problem.home)[0]:
            self._static_causes["home_blocked"] += 1
            return []
        lifted = [(back, self._lift_path(q, carried)) for q, back in open_ways]
        grasp = self._problem.grasps[number]
        found = [
            _Candidate(number, grasp, back[::-1], lift, held)
            for back, lift in lifted
            if lift is not None
        ]
        self._static_causes["lift_blocked"] += len(lifted) - len(found)
        return found

    def _worlds(
        self, object_poses: Array, opening: float, ignored: list[str]
    ) -> tuple[CollisionWorld, CollisionWorld]:
        """What the arm must not meet on its way, and on the last straight piece to the target."""
        ignored = [self._target.name, *ignored]
        world = self._collision.world(object_poses, opening=opening, ignore=ignored)
        if self._close is self._collision:
            return world, world
        return world, self._close.world(object_poses, opening=opening, ignore=ignored)

    def _carried(self, number: int, held: HeldObject) -> CollisionWorld:
        """Fixtures and immovables around the arm that holds the target."""
        return self._collision.world(
            self._problem.initial.object_poses,
            opening=self._problem.grasps[number].opening,
            ignore=[self._target.name, *self._movables],
            held=held,
        )

    def _by_opening(self, numbers: Iterable[int]) -> dict[float, list[int]]:
        """Those of the grasps the gripper is wide enough for."""
        fitting: dict[float, list[int]] = {}
        for number in numbers:
            opening = self._problem.grasps[number].opening
            if opening > self._arm.gripper.max_opening:
                self._static_causes["gripper_too_small"] += 1
            else:
                fitting.setdefault(opening, []).append(number)
        return fitting

    def _screened(self, numbers: list[int], world: CollisionWorld) -> Iterator[tuple[int, Array]]:
        """Grasps with ``T_world_tool`` (4, 4), within reach, where there is room for the hand."""
        grasps = np.array([self._problem.grasps[number].T_object_tool for number in numbers])
        tools = self._T_world_target @ matrices_from_poses(grasps)
        for number, T_grasp, free in zip(numbers, tools, world.hands_free(tools), strict=True):
            if np.linalg.norm(T_grasp[:3, 3] - self._root) > self._length:
                self._static_causes["out_of_reach"] += 1
            elif not free:
                self._static_causes["hand_blocked"] += 1
            else:
                yield number, T_grasp

    def _held_at(self, T_world_tool: Array) -> HeldObject:
        """The target in the hand, taken where it stands."""
        T = invert(T_world_tool) @ self._T_world_target
        return HeldObject(self._target.name, self._target.shape, T, up=T[:3, 2])

    def _back_path(
        self, q: Array, number: int, world: CollisionWorld, close: CollisionWorld
    ) -> Array | None:
        """Straight back from the grasp, by less where the full approach does not fit."""
        T, approach = self._kinematics.forward(q), self._problem.grasps[number].approach
        for share in _APPROACH_SHARES:
            T_back = T.copy()
            T_back[:3, 3] -= share * approach * T[:3, 0]
            line = self._kinematics.follow_line(q, T_back, step=_REACH_STEP)
            if line.fraction < 1.0 or not world.free(line.path[-1:])[0]:
                continue
            if close.free(line.path).all():
                return line.path
        return None

    def _lift_path(self, q: Array, carried: CollisionWorld) -> Array | None:
        """Straight up by as much as the ceiling leaves, at most the option's lift."""
        T = self._kinematics.forward(q)
        top = float(self._T_world_target[2, 3]) + self._target.shape.height / 2.0
        gap = float(self._problem.scene.workspace.upper[2]) - top
        height = min(self._options.lift, max(gap - self._options.ceiling_gap, gap / 2.0))
        for share in (1.0, 0.6, 0.35):
            T_up = T.copy()
            T_up[2, 3] += max(height * share, _LEAST_LIFT)
            line = self._kinematics.follow_line(q, T_up)
            if line.fraction == 1.0:
                return line.path if carried.free(line.path[-1])[0] else None
        return None

    def _unblocked(self, state: SceneState, candidates: list[_Candidate]) -> list[_Candidate]:
        """Candidates whose reach and lifted pose are free among the objects of ``state``."""
        openings = np.array([candidate.grasp.opening for candidate in candidates])
        clear = np.ones(len(candidates), dtype=np.bool_)
        for opening in set(openings.tolist()):
            same = np.flatnonzero(openings == opening)
            world, close = self._worlds(state.object_poses, opening, [])
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
        pending: list[_Candidate],
        rng: np.random.Generator,
        causes: Counter[str],
    ) -> tuple[Motion | None, list[_Candidate]]:
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

    def _motion(self, chosen: _Candidate, transit: Array, carry: Array) -> Motion:
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
        shape, across = self._target.shape, matrix_from_pose(grasp.T_object_tool)[:3, 1]
        width = np.abs(across) @ shape.size if isinstance(shape, Box) else 2.0 * shape.radius
        gap = (grasp.opening - float(width)) / 2.0
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


def _outstretched(problem: Problem, arm: ArmModel) -> tuple[Array, float]:
    """Where the arm begins (3,), and a length (m) that proves what is out of its reach.

    The links stretched out cannot be longer than their lengths.
    """
    first = next(link for link in arm.links if link.coordinate == 0)
    T_world_base = matrix_from_pose(problem.scene.T_world_base)
    chain = [link for link in arm.links if link.coordinate > 0]
    length = sum(float(np.linalg.norm(link.T_parent_joint[:3, 3])) for link in chain)
    length += float(np.linalg.norm(arm.T_link_tool[:3, 3]))
    return (T_world_base @ first.T_parent_joint)[:3, 3], length
