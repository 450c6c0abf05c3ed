"""Pushes (thesis 4.4.2, 5.4.3): approach contact-free, sweep straight, retract the same way."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np

from mamo_core.interfaces.action_generator import ActionGenerator, ActionRequest
from mamo_core.interfaces.arm_planner import ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionChecker, CollisionWorld
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.robots.kinematics import finger_transforms
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import time_path
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array, BoolArray, Shape, footprint_corners
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind
from mamo_core.types.problem import Problem
from mamo_core.types.scene import Mobility, SceneState
from mamo_core.types.solution import Statistics
from mamo_planners.actions.push_geometry import (
    ToolPose,
    ToolPoses,
    rich_tool_poses,
    thesis_tool_poses,
)
from mamo_planners.actions.push_likeness import alike
from mamo_planners.actions.push_line import PushLine, through_centre
from mamo_planners.footprints import Outlines, free_slide
from mamo_planners.ignoring import IgnoringChecker
from mamo_planners.options import PushOptions

_AGNOSTIC_LENGTHS = (0.06, 0.25)
_LINE_STEP = 0.01
_QUERY_SIZE = 6
_SCREEN_STEP = 0.02
_SCREENED_AT_ONCE = 12
_SHUFFLE = 0.4


@dataclass(frozen=True, eq=False)
class _Start:
    """A configuration behind the object and the sweep (k, dof) from it."""

    sweep: Array
    info: dict[str, float]


class Push(ActionGenerator):
    """One straight push per proposal; the goal is the farthest the object can slide straight."""

    def __init__(
        self,
        problem: Problem,
        arm: ArmModel,
        kinematics: Kinematics,
        collision: CollisionChecker,
        arm_planner: ArmPlanner,
        options: PushOptions,
        gone: Collection[str] = (),
        kind: str = "push",
    ) -> None:
        """``gone``: things that pushed objects do not meet. ``kind``: of what it proposes."""
        self._kind = kind
        self._problem, self._arm, self._options = problem, arm, options
        self._kinematics, self._collision, self._arm_planner = kinematics, collision, arm_planner
        self._opening = arm.gripper.closed
        scene = problem.scene
        self._movables = [o.name for o in scene.objects if o.mobility is Mobility.MOVABLE]
        fixed = [
            i
            for i, o in enumerate(scene.objects)
            if o.mobility is not Mobility.MOVABLE and o.name not in gone
        ]
        poses = problem.initial.object_poses
        self._obstacles = Outlines(
            [footprint_corners(scene.objects[i].shape, poses[i]) for i in fixed]
        )
        self._hand = _hand_spheres(arm, self._opening)
        self._rich = self._low(rich_tool_poses())

    def propose(
        self,
        state: SceneState,
        request: ActionRequest,
        rng: np.random.Generator,
        statistics: Statistics,
    ) -> Iterator[RearrangementAction]:
        number = self._problem.scene.index(request.object_name)
        shape, pose = self._problem.scene.objects[number].shape, state.object_poses[number]
        delta = self._displacement(shape, pose, request, rng)
        length = float(np.linalg.norm(delta))
        if length < self._options.shortest:
            statistics.failed(request.object_name, self._kind, "no_room")
            return
        line = through_centre(shape, pose, delta)
        if self._options.longest is not None:
            line = line.by(min(length, self._options.longest))
        yield from self.along(state, request.object_name, line, rng, statistics)

    def along(
        self,
        state: SceneState,
        name: str,
        line: PushLine,
        rng: np.random.Generator,
        statistics: Statistics,
    ) -> Iterator[RearrangementAction]:
        """Pushes along a line, likely ones first, computed when asked for."""
        with statistics.timed("push_poses"):
            starts = self._starts(state, name, line, rng, statistics)
        position = state.object_poses[self._problem.scene.index(name), :2]
        goal = np.stack([position, position + line.delta])
        yield from self._approached(state, name, starts, goal, rng, statistics)

    def alike(self, action: RearrangementAction, failed: RearrangementAction) -> bool:
        """As the option ``alike`` has it."""
        return alike(action, failed, self._options.alike)

    def without(self, names: Collection[str]) -> Push:
        return Push(
            self._problem,
            self._arm,
            self._kinematics,
            IgnoringChecker(self._collision, names),
            self._arm_planner,
            self._options,
            gone=names,
            kind=self._kind,
        )

    def _displacement(
        self, shape: Shape, pose: Array, request: ActionRequest, rng: np.random.Generator
    ) -> Array:
        """Where the object should go (2,), from where it is."""
        workspace = self._problem.scene.workspace
        lower, upper = workspace.lower[:2].copy(), workspace.upper[:2]
        lower[0] -= workspace.overhang
        if request.path is None:
            angle = rng.uniform(-np.pi, np.pi)
            length = rng.uniform(*_AGNOSTIC_LENGTHS)
            aim = length * np.array([np.cos(angle), np.sin(angle)])
            return self._slide(shape, pose, aim, lower, upper)
        if self._options.geometry == "thesis":
            return request.path[-1] - pose[:2]
        # The farthest point of the path that a straight sweep reaches.
        for point in request.path[::-1]:
            aim = point - pose[:2]
            slid = self._slide(shape, pose, aim, lower, upper)
            if np.linalg.norm(slid) >= np.linalg.norm(aim) - 1e-9:
                return aim
        return np.zeros(2)

    def _slide(self, shape: Shape, pose: Array, aim: Array, lower: Array, upper: Array) -> Array:
        """The part of ``aim`` that keeps clear of whatever must not be touched."""
        count = max(1, int(np.ceil(np.linalg.norm(aim) / 0.01)))
        moves = aim * (np.arange(1, count + 1) / count)[:, None]
        # An object that overhangs may stay so; only growing further out is refused.
        corners = footprint_corners(shape, pose)
        low = np.minimum(lower, corners.min(axis=0))
        high = np.maximum(upper, corners.max(axis=0))
        return aim * (free_slide(shape, pose, moves, self._obstacles, low, high) / count)

    def _starts(
        self,
        state: SceneState,
        name: str,
        line: PushLine,
        rng: np.random.Generator,
        statistics: Statistics,
    ) -> list[_Start]:
        """Arm configurations behind the object whose sweep is clear of what is fixed."""
        everything = self._collision.world(state.object_poses, opening=self._opening)
        fixed_only = self._collision.world(
            state.object_poses, opening=self._opening, ignore=self._movables
        )
        found: list[_Start] = []
        tools = self._screened(line, rng, everything, fixed_only)
        blocked = True
        for tool, T in islice(tools, self._options.poses):
            blocked = False
            solutions = self._kinematics.inverse(T, rng, count=self._options.branches)
            if not len(solutions):
                statistics.failed(name, self._kind, "no_ik")
                continue
            free = everything.free(solutions)
            statistics.failed(name, self._kind, "start_blocked", int((~free).sum()))
            travel = self._travel(line, tool.stand_off)
            for q in solutions[free]:
                sweep = self._sweep(q, T, line.direction, travel, fixed_only, name, statistics)
                if sweep is not None:
                    found.append(_Start(sweep, {"yaw": tool.yaw_offset, "pitch": tool.pitch}))
            if len(found) >= self._options.starts:
                break
        statistics.failed(name, self._kind, "hand_blocked", int(blocked))
        return found

    def _travel(self, line: PushLine, stand_off: float) -> float:
        """Length of the sweep, m."""
        return line.length + stand_off + self._options.overshoot

    def _screened(
        self,
        line: PushLine,
        rng: np.random.Generator,
        everything: CollisionWorld,
        fixed_only: CollisionWorld,
    ) -> Iterator[tuple[ToolPose, Array]]:
        """Tool poses where the hand fits at the start and along the sweep; likely ones first."""
        tools = self._tool_poses(rng)
        starts = tools.behind(line.origin, line.direction, line.extent)
        fitting = np.flatnonzero(everything.hands_free(starts))
        cost = tools.awkwardness + rng.uniform(0.0, _SHUFFLE, len(tools.poses))
        order = fitting[np.argsort(cost[fitting], kind="stable")]
        ways = {
            off: _steps_along(line.direction, self._travel(line, off))
            for off in set(tools.stand_offs)
        }
        for first in range(0, len(order), _SCREENED_AT_ONCE):
            some = order[first : first + _SCREENED_AT_ONCE].tolist()
            swept = [ways[tools.stand_offs[k]] for k in some]
            for k, free in zip(some, _all_free(fixed_only, starts[some], swept), strict=True):
                if free:
                    yield tools.poses[k], starts[k]

    def _tool_poses(self, rng: np.random.Generator) -> ToolPoses:
        if self._options.geometry == "thesis":
            return self._low(thesis_tool_poses(rng))
        return self._rich

    def _low(self, poses: list[ToolPose]) -> ToolPoses:
        """Tool poses with the hand close over the floor."""
        return ToolPoses(
            poses, self._hand, self._problem.scene.workspace.floor, self._options.floor_gap
        )

    def _sweep(
        self,
        q: Array,
        T: Array,
        direction: Array,
        travel: float,
        world: CollisionWorld,
        name: str,
        statistics: Statistics,
    ) -> Array | None:
        T_end = T.copy()
        T_end[:2, 3] += direction * travel
        followed = self._kinematics.follow_line(q, T_end, step=_LINE_STEP)
        if followed.fraction < 1.0:
            statistics.failed(name, self._kind, "line_untrackable")
            return None
        if not world.free(followed.path).all():
            statistics.failed(name, self._kind, "sweep_blocked")
            return None
        return followed.path

    def _approached(
        self,
        state: SceneState,
        name: str,
        starts: list[_Start],
        goal: Array,
        rng: np.random.Generator,
        statistics: Statistics,
    ) -> Iterator[RearrangementAction]:
        """Reach the starts by multi-goal queries, a few of the best at a time."""
        world = self._collision.world(state.object_poses, opening=self._opening)
        pending = list(starts)
        for _ in range(self._options.samples):
            if not pending:
                return
            batch = pending[:_QUERY_SIZE]
            with statistics.timed("arm_planning"):
                goals = np.array([s.sweep[0] for s in batch])
                plan = self._arm_planner.plan(state.joint_positions, goals, world, rng)
            statistics.counts["arm_plans"] += 1
            if plan.path is None:
                statistics.failed(name, self._kind, f"approach_{plan.status}")
                pending = pending[_QUERY_SIZE:]
                continue
            chosen = batch[plan.goal]
            pending.remove(chosen)
            yield self._action(name, plan.path, chosen, goal)

    def _action(
        self, name: str, approach: Array, start: _Start, goal: Array
    ) -> RearrangementAction:
        options, opening, limits = self._options, self._opening, self._arm.limits
        tools = np.array([self._kinematics.forward(q)[:3, 3] for q in start.sweep])
        sweep = time_path(
            start.sweep,
            limits,
            scale=options.joint_speed,
            tool_positions=tools,
            tool_speed=options.sweep_speed,
        )
        retract = time_path(
            start.sweep[::-1],
            limits,
            scale=options.joint_speed,
            tool_positions=tools[::-1],
            tool_speed=2.0 * options.sweep_speed,
        )
        transit = time_path(approach, limits, scale=options.joint_speed)
        motion = Motion(
            (
                MotionSegment(SegmentKind.TRANSIT, transit, opening, contact_free=True),
                MotionSegment(SegmentKind.SWEEP, sweep, opening, settle=options.settle),
                MotionSegment(SegmentKind.RETRACT, retract, opening, settle=options.settle),
            ),
            opening,
        )
        return RearrangementAction(self._kind, name, motion, goal, start.info)


def _steps_along(direction: Array, travel: float) -> Array:
    """Displacements (k, 2) from nothing to ``travel`` (m) along ``direction`` (2,)."""
    count = max(2, int(np.ceil(travel / _SCREEN_STEP)) + 1)
    return np.linspace(0.0, travel, count)[:, None] * direction


def _all_free(world: CollisionWorld, tools: Array, ways: list[Array]) -> BoolArray:
    """From which of ``tools`` (n, 4, 4) the hand is clear all the way.

    ``ways``: displacements (k, 2) of each from where it is.
    """
    counts = [len(way) for way in ways]
    swept = np.repeat(tools, counts, axis=0)
    swept[:, :2, 3] += np.concatenate(ways)
    starts = np.cumsum([0, *counts[:-1]])
    return np.logical_and.reduceat(world.hands_free(swept), starts)


def _hand_spheres(arm: ArmModel, opening: float) -> Array:
    """Spheres (k, 4) of hand and fingers in the tool frame."""
    T_tool_link = np.linalg.inv(arm.T_link_tool)
    parts = [(T_tool_link, arm.links[arm.tool_link].spheres)]
    for number, T in finger_transforms(arm.links, arm.gripper.drive(opening)).items():
        parts.append((T_tool_link @ T, arm.links[number].spheres))
    return np.vstack(
        [np.column_stack([s[:, :3] @ T[:3, :3].T + T[:3, 3], s[:, 3]]) for T, s in parts]
    )
