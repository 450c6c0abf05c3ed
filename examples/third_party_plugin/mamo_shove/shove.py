"""Shoves: straight pushes in random directions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from pydantic import Field

from mamo_core.hookspecs import Options
from mamo_core.interfaces.action_generator import ActionGenerator, ActionRequest
from mamo_core.interfaces.arm_planner import ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import time_path
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array, Shape, tool_matrix
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind
from mamo_core.types.problem import Problem
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Statistics


class ShoveOptions(Options):
    """How to shove."""

    attempts: int = Field(default=8, ge=1, description="directions to try for each request")
    distance: float = Field(default=0.12, gt=0.0, description="length of the sweep, m")
    standoff: float = Field(default=0.05, gt=0.0, description="gap to the object at first, m")
    height: float = Field(default=0.05, gt=0.0, description="height of the tool, m above the floor")
    speed: float = Field(default=0.3, gt=0.0, le=1.0, description="fraction of the joint limits")
    max_yaw: float = Field(default=0.6, ge=0.0, description="turn of the tool from world x, rad")
    settle: float = Field(default=1.0, ge=0.0, description="longest wait for objects to rest, s")


@dataclass(frozen=True, eq=False)
class Shove(ActionGenerator):
    """Proposes a shove for each direction that the arm can reach."""

    problem: Problem
    robot: ArmModel
    kinematics: Kinematics
    collision: CollisionChecker
    arm_planner: ArmPlanner
    options: ShoveOptions

    def propose(
        self,
        state: SceneState,
        request: ActionRequest,
        rng: np.random.Generator,
        statistics: Statistics,
    ) -> Iterator[RearrangementAction]:
        """One action for each direction that works, in random order."""
        for angle in rng.uniform(-np.pi / 2.0, np.pi / 2.0, self.options.attempts):
            shove = self._shove(state, request.object_name, float(angle), rng)
            if isinstance(shove, str):
                statistics.failed(request.object_name, "shove", shove)
            else:
                yield shove

    def _shove(
        self, state: SceneState, name: str, angle: float, rng: np.random.Generator
    ) -> RearrangementAction | str:
        """A shove along ``angle`` (rad, world), or why there is none."""
        index = self.problem.scene.index(name)
        shape, pose = self.problem.scene.objects[index].shape, state.object_poses[index]
        direction = np.array([np.cos(angle), np.sin(angle), 0.0])
        T_start = self._tool_start(shape, pose, direction, angle)
        goals = self.kinematics.inverse(T_start, rng, count=4, near=state.joint_positions)
        if len(goals) == 0:
            return "no_ik"
        closed = self.robot.gripper.closed
        world = self.collision.world(state.object_poses, opening=closed)
        approach = self.arm_planner.plan(state.joint_positions, goals, world, rng)
        if approach.path is None:
            return f"approach_{approach.status}"
        sweep = self._sweep(state, approach.path[-1], T_start, direction)
        if isinstance(sweep, str):
            return sweep
        path = np.stack([pose[:2], pose[:2] + self.options.distance * direction[:2]])
        motion = self._motion(approach.path, sweep, closed)
        return RearrangementAction("shove", name, motion, path, {"angle": angle})

    def _tool_start(self, shape: Shape, pose: Array, direction: Array, angle: float) -> Array:
        """``T_world_tool`` behind the object; the arm cannot turn its back to the shelf."""
        behind = shape.footprint_radius + self.options.standoff
        yaw = float(np.clip(angle, -self.options.max_yaw, self.options.max_yaw))
        start = pose[:3] - behind * direction
        # Low down, or the object tips over.
        start[2] = self.problem.scene.workspace.floor + self.options.height
        return tool_matrix(start, yaw)

    def _sweep(
        self, state: SceneState, start: Array, T_start: Array, direction: Array
    ) -> Array | str:
        """Configurations of the straight push, or why there are none."""
        T_end = T_start.copy()
        T_end[:3, 3] += (self.options.standoff + self.options.distance) * direction
        line = self.kinematics.follow_line(start, T_end)
        if line.fraction < 1.0:
            return "no_line"
        # Movables may be touched: physics decides. Everything else may not.
        scene = self.problem.scene
        movables = [scene.objects[i].name for i in scene.movable_indices]
        world = self.collision.world(
            state.object_poses, opening=self.robot.gripper.closed, ignore=movables
        )
        free = world.edges_free(line.path[:-1], line.path[1:]).all()
        return line.path if free else "sweep_blocked"

    def _motion(self, approach: Array, sweep: Array, opening: float) -> Motion:
        """There, through, and back the same way."""

        def segment(
            kind: SegmentKind, path: Array, contact_free: bool, settle: float = 0.0
        ) -> MotionSegment:
            trajectory = time_path(path, self.robot.velocity, scale=self.options.speed)
            return MotionSegment(kind, trajectory, opening, None, contact_free, settle)

        return Motion(
            (
                segment(SegmentKind.TRANSIT, approach, True),
                segment(SegmentKind.SWEEP, sweep, False, self.options.settle),
                segment(SegmentKind.RETRACT, sweep[::-1], False),
                segment(SegmentKind.TRANSIT, approach[::-1], True),
            ),
            opening,
        )
