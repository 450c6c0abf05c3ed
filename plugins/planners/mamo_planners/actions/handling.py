"""How one object can be taken and put down at one state: straight motions, checked."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionChecker, CollisionWorld, HeldObject
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.robots.grip import grip_fault
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import (
    Array,
    BoolArray,
    IntArray,
    invert,
    matrices_from_poses,
    matrix_from_pose,
)
from mamo_core.types.problem import Problem
from mamo_core.types.scene import Fixture, SceneState
from mamo_planners.actions.grasp_set import GraspSet
from mamo_planners.options import PickPlaceOptions

_STEP = 0.01
_SCREENED = 5
_GRASPS_AT_ONCE = 4
_APPROACH_SHARES = (1.0, 0.65)
_EXTRA_RETRACT = (0.0, 0.06, 0.12, 0.2)
_LIFT_SHARES = (1.0, 0.5, 0.25)
_LEAST_LIFT = 0.005
_ON_FLOOR = 1e-3
_PITCH_COST, _SHUFFLE = 0.5, 0.3

Count = Callable[[str, int], None]
"""Counts failures by their cause."""


@dataclass(frozen=True, eq=False)
class Parts:
    """What the action is built from."""

    problem: Problem
    arm: ArmModel
    kinematics: Kinematics
    collision: CollisionChecker
    options: PickPlaceOptions


@dataclass(frozen=True, eq=False)
class Pickup:
    """A grasp with configurations: ``reach`` (k, dof) straight to it, ``lift`` (k, dof) from it.

    ``opening``: of the fingers before and after, m; ``width``: of the object between them, m.
    """

    opening: float
    width: float
    reach: Array
    lift: Array
    held: HeldObject


@dataclass(frozen=True, eq=False)
class Drop:
    """The object at ``pose`` (7,): ``lower`` (k, dof) straight to it, ``retract`` (k, dof) back.

    ``clear``: whether the hand may close where the retract ends, and the arm stay there.
    """

    pose: Array
    lower: Array
    retract: Array
    clear: bool


class Handling:
    """Grasps of one object at one state, and how it can be put down again."""

    def __init__(
        self,
        parts: Parts,
        state: SceneState,
        number: int,
        grasps: GraspSet,
        rng: np.random.Generator,
        count: Count,
    ) -> None:
        self._p, self._state, self._rng, self._count = parts, state, rng, count
        item = parts.problem.scene.objects[number]
        self._number, self._item = number, item
        self._name, self._shape = item.name, item.shape
        self._T_object = matrix_from_pose(state.object_poses[number])
        self._g = grasps
        self._floor = [f.name for f in parts.problem.scene.fixtures if self._is_floor(f)]
        self._worlds: dict[tuple[float, bool], CollisionWorld] = {}
        self._loaded: dict[tuple[HeldObject, bool], CollisionWorld] = {}
        self._tools = self._T_object @ grasps.T_object_tool
        order = self._order()
        self._fitting = order[self._hand_fits(order, self._tools[order])]

    def world(self, opening: float, *, without: bool = True) -> CollisionWorld:
        """The world around the arm (fingers at ``opening``, m), with or ``without`` the object."""
        key = (opening, without)
        if key not in self._worlds:
            ignore = [self._name] if without else []
            self._worlds[key] = self._p.collision.world(
                self._state.object_poses, opening=opening, ignore=ignore
            )
        return self._worlds[key]

    def carrying(self, pickup: Pickup, *, over_floor: bool = False) -> CollisionWorld:
        """The world around the arm with the object; ``over_floor``: the floor does not count."""
        key = (pickup.held, over_floor)
        if key not in self._loaded:
            ignore = [self._name, *self._floor] if over_floor else [self._name]
            self._loaded[key] = self._p.collision.world(
                self._state.object_poses, opening=pickup.width, ignore=ignore, held=pickup.held
            )
        return self._loaded[key]

    def placed(self, pose: Array, opening: float, margin: float = 0.0) -> CollisionWorld:
        """The world around the arm (fingers at ``opening``, m) with the object put at ``pose``."""
        poses = np.array(self._state.object_poses)
        poses[self._number] = pose
        return self._p.collision.world(poses, opening=opening, margin=margin)

    def graspable(self) -> bool:
        """Whether there is room for the open hand at some grasp; otherwise that is counted."""
        self._count("grasp_hand_blocked", int(not len(self._fitting)))
        return len(self._fitting) > 0

    def transfers(self, places: Array) -> Iterator[tuple[Pickup, list[Drop]]]:
        """Grasps that can be reached and from which the object fits at some of ``places`` (n, 7).

        Likely ones first.
        """
        put = matrices_from_poses(places)
        fitting = self._fitting_goals(put)
        none = True
        for grasp, fits, tools in islice(fitting, self._p.options.grasps):
            none = False
            goals = list(zip(places[fits], tools, strict=True))
            for pickup in self._pickups(grasp):
                if not goals:
                    break
                drops = self._drops(grasp, pickup, goals)
                if drops:
                    yield pickup, drops
        self._count("place_hand_blocked", int(none))

    def _fitting_goals(self, put: Array) -> Iterator[tuple[int, IntArray, Array]]:
        """Grasps with which there is room for the hand at some of ``put`` (n, 4, 4).

        With the numbers (k,) of these places, and the tool (k, 4, 4) there.
        """
        for first in range(0, len(self._fitting), _GRASPS_AT_ONCE):
            some = self._fitting[first : first + _GRASPS_AT_ONCE]
            tools = put[None] @ self._g.T_object_tool[some][:, None]
            flat = tools.reshape(-1, 4, 4)
            fits = self._hand_fits(np.repeat(some, len(put)), flat).reshape(tools.shape[:2])
            for n in np.flatnonzero(fits.any(axis=1)):
                if not self._holds(int(some[n])):
                    continue
                places = np.flatnonzero(fits[n])
                yield int(some[n]), places, tools[n, places]

    def _holds(self, grasp: int) -> bool:
        """Whether friction is enough to carry the object with a grasp; otherwise it is counted."""
        T_tool_object, width = invert(self._g.T_object_tool[grasp]), float(self._g.widths[grasp])
        fault = grip_fault(self._item, T_tool_object, width, self._p.arm)
        if fault is not None:
            self._count(fault, 1)
        return fault is None

    def _order(self) -> IntArray:
        """Grasps that look into the shelf first; some chance, for other ones when asked again."""
        x = self._tools[:, :3, 0]
        yaws = np.abs(np.arctan2(x[:, 1], x[:, 0]))
        pitches = np.arcsin(np.clip(-x[:, 2], -1.0, 1.0))
        cost = yaws + _PITCH_COST * pitches + self._rng.uniform(0.0, _SHUFFLE, len(x))
        usable = np.flatnonzero(yaws <= self._p.options.widest_yaw)
        return usable[np.argsort(cost[usable], kind="stable")]

    def _hand_fits(self, grasps: IntArray, tools: Array) -> BoolArray:
        """Whether the open hand of ``grasps`` (n,) fits at ``tools`` (n, 4, 4) and on the way."""
        left = np.arange(len(grasps))
        openings = self._g.openings[grasps]
        steps = _APPROACH_SHARES[-1] * self._g.approaches[grasps]
        for share in np.linspace(0.0, 1.0, _SCREENED):
            T = tools[left].copy()
            T[:, :3, 3] -= (share * steps[left])[:, None] * T[:, :3, 0]
            free = np.zeros(len(left), dtype=np.bool_)
            for opening in sorted(set(openings[left].tolist())):
                same = openings[left] == opening
                free[same] = self.world(opening).hands_free(T[same])
            left = left[free]
        fits = np.zeros(len(grasps), dtype=np.bool_)
        fits[left] = True
        return fits

    def _pickups(self, grasp: int) -> Iterator[Pickup]:
        T, branches = self._tools[grasp], self._p.options.branches
        solutions = self._p.kinematics.inverse(T, self._rng, count=branches)
        if not len(solutions):
            self._count("grasp_no_ik", 1)
        for q in solutions:
            pickup = self._pickup(grasp, q)
            if pickup is not None:
                yield pickup

    def _pickup(self, grasp: int, q: Array) -> Pickup | None:
        opening, approach = float(self._g.openings[grasp]), float(self._g.approaches[grasp])
        if not self.world(opening).free(q)[0]:
            self._count("grasp_blocked", 1)
            return None
        T = self._p.kinematics.forward(q)
        shares = [share * approach for share in _APPROACH_SHARES]
        back = self._back(q, T, opening, shares, [self.world(opening, without=False)])
        if back is None:
            self._count("reach_blocked", 1)
            return None
        width = float(self._g.widths[grasp])
        held = HeldObject(self._name, self._shape, invert(T) @ self._T_object, np.array(T[2, :3]))
        bare = Pickup(opening, width, back[::-1], back[:1], held)
        lift = self._up(q, T, bare, float(self._T_object[2, 3]))
        if lift is None:
            self._count("lift_blocked", 1)
            return None
        return Pickup(opening, width, back[::-1], lift, held)

    def _back(
        self,
        q: Array,
        T: Array,
        opening: float,
        lengths: Sequence[float],
        clear: Sequence[CollisionWorld],
    ) -> Array | None:
        """Straight back (k, dof) from the object by the first length that ends ``clear``."""
        for length in lengths:
            T_back = T.copy()
            T_back[:3, 3] -= length * T[:3, 0]
            line = self._p.kinematics.follow_line(q, T_back, step=_STEP)
            if line.fraction < 1.0 or not self.world(opening).free(line.path).all():
                continue
            if all(world.free(line.path[-1])[0] for world in clear):
                return line.path
        return None

    def _up(self, q: Array, T: Array, pickup: Pickup, height: float) -> Array | None:
        """Straight up (k, dof) with the object (its centre at ``height``, m), clear of the floor.

        The object cannot hit the floor it stands on or comes down to, so only the arm is checked
        for that on the way.
        """
        top = height + self._shape.height / 2.0
        gap = float(self._p.problem.scene.workspace.upper[2]) - top
        full = min(self._p.options.lift, max(gap - self._p.options.ceiling_gap, gap / 2.0))
        carrying, over = self.carrying(pickup), self.carrying(pickup, over_floor=True)
        for share in _LIFT_SHARES:
            T_up = T.copy()
            T_up[2, 3] += max(full * share, _LEAST_LIFT)
            line = self._p.kinematics.follow_line(q, T_up, step=_STEP)
            if line.fraction < 1.0 or not carrying.free(line.path[-1])[0]:
                continue
            if over.free(line.path).all() and self.world(pickup.width).free(line.path).all():
                return line.path
        return None

    def _drops(self, grasp: int, pickup: Pickup, goals: list[tuple[Array, Array]]) -> list[Drop]:
        """Ways to put the object down; ``goals`` the arm cannot reach are taken off the list."""
        found: list[Drop] = []
        for goal in list(goals):
            pose, T = goal
            solutions = self._p.kinematics.inverse(T, self._rng, count=1, near=pickup.lift[-1])
            if not len(solutions):
                self._count("place_no_ik", 1)
                goals[:] = [other for other in goals if other is not goal]
                continue
            drop = self._drop(grasp, pickup, pose, solutions[0])
            if drop is not None:
                found.append(drop)
            if len(found) >= self._p.options.drops:
                break
        return found

    def _drop(self, grasp: int, pickup: Pickup, pose: Array, q: Array) -> Drop | None:
        if not self.world(pickup.opening).free(q)[0]:
            self._count("place_blocked", 1)
            return None
        T = self._p.kinematics.forward(q)
        up = self._up(q, T, pickup, float(pose[2]))
        if up is None:
            self._count("lower_blocked", 1)
            return None
        drop = self._away(grasp, q, T, pose, up[::-1])
        if drop is None:
            self._count("retract_blocked", 1)
        return drop

    def _away(self, grasp: int, q: Array, T: Array, pose: Array, lower: Array) -> Drop | None:
        """Back from the placed object, if possible to where the gripper may close and stay."""
        margin = self._p.options.clearance
        opening, approach = float(self._g.openings[grasp]), float(self._g.approaches[grasp])
        ways = (opening, self._p.arm.gripper.closed)
        clear = [self.placed(pose, way, margin) for way in ways]
        lengths = [approach + extra for extra in _EXTRA_RETRACT]
        back = self._back(q, T, opening, lengths, clear)
        if back is not None:
            return Drop(pose, lower, back, clear=True)
        shares = [share * approach for share in _APPROACH_SHARES]
        back = self._back(q, T, opening, shares, [self.placed(pose, opening)])
        return None if back is None else Drop(pose, lower, back, clear=False)

    def _is_floor(self, fixture: Fixture) -> bool:
        """Whether a fixture lies wholly below what the objects stand on."""
        top = float(fixture.pose[2]) + fixture.shape.height / 2.0
        return top <= self._p.problem.scene.workspace.floor + _ON_FLOOR
