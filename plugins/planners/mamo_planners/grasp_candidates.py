"""The grasps by which the arm can take the target past whatever cannot be moved."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionChecker, CollisionWorld, HeldObject
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.robots.exact_collision import ExactChecker
from mamo_core.robots.grasps import widths_between_fingers
from mamo_core.robots.grip import grip_fault
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, invert, matrices_from_poses, matrix_from_pose
from mamo_core.types.problem import Grasp, Problem
from mamo_core.types.scene import Mobility
from mamo_planners.options import RetrievalOptions

_LEAST_LIFT = 0.003
_SEED = 0
_THOROUGH = 20
_AT_ONCE = 16
_REACH_STEP = 0.01
_APPROACH_SHARES = (1.0, 0.65, 0.45, 0.3)


@dataclass(frozen=True, eq=False)
class Candidate:
    """A grasp the arm can reach past fixtures and immovables: ``reach`` and ``lift`` (k, dof).

    ``number``: of the grasp in the problem. ``width``: what the target leaves between the fingers,
    m. ``held``: the target in the hand.
    """

    number: int
    grasp: Grasp
    width: float
    reach: Array
    lift: Array
    held: HeldObject


class GraspCandidates:
    """They depend on nothing that moves; ``found``, and ``causes`` why others are not usable."""

    def __init__(
        self,
        problem: Problem,
        arm: ArmModel,
        kinematics: Kinematics,
        collision: CollisionChecker,
        options: RetrievalOptions,
        patient: bool = True,
    ) -> None:
        """``patient``: look much harder before saying that no grasp works."""
        self._problem, self._arm, self._kinematics = problem, arm, kinematics
        self._collision, self._options = collision, options
        scene = problem.scene
        self._target = scene.objects[scene.target_index]
        self._movables = [o.name for o in scene.objects if o.mobility is Mobility.MOVABLE]
        self._T_world_target = matrix_from_pose(problem.initial.object_poses[scene.target_index])
        self._root, self._length = _outstretched(problem, arm)
        self.causes: Counter[str] = Counter()
        self._close = collision
        """Checks the way in to the target."""
        self.found = self._find(options.branches)
        if patient and not self.found:
            # Tight places leave few arm configurations: look harder before saying there are none.
            self.found = self._find(_THOROUGH * options.branches)
        if patient and not self.found:
            # The covers leave no way; the meshes, which have the last word anyhow, may leave one.
            self._close = ExactChecker(scene, arm)
            self.found = self._find(_THOROUGH * options.branches)

    def worlds(
        self, object_poses: Array, opening: float, ignored: list[str]
    ) -> tuple[CollisionWorld, CollisionWorld]:
        """What the arm must not meet on its way, and on the last straight piece to the target."""
        ignored = [self._target.name, *ignored]
        world = self._collision.world(object_poses, opening=opening, ignore=ignored)
        if self._close is self._collision:
            return world, world
        return world, self._close.world(object_poses, opening=opening, ignore=ignored)

    def held_at(self, T_world_tool: Array) -> HeldObject:
        """The target in the hand, taken where it stands."""
        target, T_world_target = self._target, self._T_world_target
        return HeldObject.taken(target.name, target.shape, T_world_tool, T_world_target)

    def _find(self, branches: int) -> list[Candidate]:
        """Grasps are looked at in the problem's order until enough of them work."""
        self.causes.clear()
        rng = np.random.default_rng(_SEED)
        found: list[Candidate] = []
        for start in range(0, len(self._problem.grasps), _AT_ONCE):
            numbers = range(start, min(start + _AT_ONCE, len(self._problem.grasps)))
            for opening, some in self._by_opening(numbers).items():
                poses, ignored = self._problem.initial.object_poses, self._movables
                world, close = self.worlds(poses, opening, ignored)
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
    ) -> list[Candidate]:
        """The ways in and up for one grasp."""
        grasp = self._problem.grasps[number]
        width = self._width(grasp)
        T_tool_target = invert(matrix_from_pose(grasp.T_object_tool))
        fault = grip_fault(self._target, T_tool_target, width, self._arm)
        if fault is not None:
            self.causes[fault] += 1
            return []
        solutions = self._kinematics.inverse(T_grasp, rng, count=branches)
        if not len(solutions):
            self.causes["grasp_no_ik"] += 1
            return []
        free = close.free(solutions)
        self.causes["grasp_in_collision"] += int((~free).sum())
        ways = [(q, self._back_path(q, number, world, close)) for q in solutions[free]]
        open_ways = [(q, back) for q, back in ways if back is not None]
        self.causes["reach_blocked"] += len(ways) - len(open_ways)
        if not open_ways:
            return []
        held = self.held_at(T_grasp)
        carried = self._carried(width, held)
        if not carried.free(self._problem.home)[0]:
            self.causes["home_blocked"] += 1
            return []
        lifted = [(back, self._lift_path(q, carried)) for q, back in open_ways]
        found = [
            Candidate(number, grasp, width, back[::-1], lift, held)
            for back, lift in lifted
            if lift is not None
        ]
        self.causes["lift_blocked"] += len(lifted) - len(found)
        return found

    def _screened(self, numbers: list[int], world: CollisionWorld) -> Iterator[tuple[int, Array]]:
        """Grasps with ``T_world_tool`` (4, 4), within reach, where there is room for the hand."""
        grasps = np.array([self._problem.grasps[number].T_object_tool for number in numbers])
        tools = self._T_world_target @ matrices_from_poses(grasps)
        for number, T_grasp, free in zip(numbers, tools, world.hands_free(tools), strict=True):
            if np.linalg.norm(T_grasp[:3, 3] - self._root) > self._length:
                self.causes["out_of_reach"] += 1
            elif not free:
                self.causes["hand_blocked"] += 1
            else:
                yield number, T_grasp

    def _by_opening(self, numbers: Iterable[int]) -> dict[float, list[int]]:
        """Those of the grasps the gripper is wide enough for."""
        fitting: dict[float, list[int]] = {}
        for number in numbers:
            opening = self._problem.grasps[number].opening
            if opening > self._arm.gripper.max_opening:
                self.causes["gripper_too_small"] += 1
            else:
                fitting.setdefault(opening, []).append(number)
        return fitting

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

    def _width(self, grasp: Grasp) -> float:
        T_object_tool = matrix_from_pose(grasp.T_object_tool)
        return float(widths_between_fingers(self._target.shape, T_object_tool[None])[0])

    def _carried(self, width: float, held: HeldObject) -> CollisionWorld:
        """Fixtures and immovables around the arm that holds the target, closed on it."""
        return self._collision.world(
            self._problem.initial.object_poses,
            opening=width,
            ignore=[self._target.name, *self._movables],
            held=held,
        )

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
