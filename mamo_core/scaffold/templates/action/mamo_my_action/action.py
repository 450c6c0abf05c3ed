"""The action: straight pushes along the way an object should go.

To make it yours, begin with ``_directions``, which says what is tried, best first. The functions
below it turn a direction into a motion: approach, sweep, and back the same way.
"""

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

KIND = "my_action"


class MyActionOptions(Options):
    """What a recipe may set: ``{name: my_action, attempts: 12}``."""

    attempts: int = Field(default=8, ge=1, description="directions to try for each request")
    spread: float = Field(default=0.4, ge=0.0, description="turn of all but the first, rad")
    longest: float = Field(default=0.15, gt=0.0, description="longest push, m")
    standoff: float = Field(default=0.05, gt=0.0, description="gap to the object at first, m")
    height: float = Field(default=0.05, gt=0.0, description="height of the tool, m above the floor")
    speed: float = Field(default=0.3, gt=0.0, le=1.0, description="fraction of the joint limits")
    max_yaw: float = Field(default=0.6, ge=0.0, description="turn of the tool from world x, rad")
    settle: float = Field(default=1.0, ge=0.0, description="longest wait for objects to rest, s")


@dataclass(frozen=True, eq=False)
class MyAction(ActionGenerator):
    """Proposes a push for each direction that the arm can reach."""

    problem: Problem
    robot: ArmModel
    kinematics: Kinematics
    collision: CollisionChecker
    arm_planner: ArmPlanner
    options: MyActionOptions

    def propose(
        self,
        state: SceneState,
        request: ActionRequest,
        rng: np.random.Generator,
        statistics: Statistics,
    ) -> Iterator[RearrangementAction]:
        """One action for each displacement that works; the search simulates them in turn."""
        name = request.object_name
        pose = state.object_poses[self.problem.scene.index(name)]
        for displacement in self._directions(pose[:2], request, rng):
            push = self._push(state, name, displacement, rng)
            if isinstance(push, str):
                statistics.failed(name, KIND, push)
            else:
                yield push

    def _directions(
        self, here: Array, request: ActionRequest, rng: np.random.Generator
    ) -> Iterator[Array]:
        """Displacements (2,) of the object to try, m, world: EDIT HERE.

        First straight to the end of the path, then turned a little; any way without a path.
        """
        for attempt in range(self.options.attempts):
            if request.path is None:
                angle, length = rng.uniform(-np.pi, np.pi), self.options.longest
            else:
                way = request.path[-1] - here
                turn = rng.normal(scale=self.options.spread) if attempt else 0.0
                angle = np.arctan2(way[1], way[0]) + turn
                length = min(float(np.linalg.norm(way)), self.options.longest)
            yield length * np.array([np.cos(angle), np.sin(angle)])

    def _push(
        self, state: SceneState, name: str, displacement: Array, rng: np.random.Generator
    ) -> RearrangementAction | str:
        """The push that moves the object by ``displacement`` (2,), or why there is none."""
        index = self.problem.scene.index(name)
        shape, pose = self.problem.scene.objects[index].shape, state.object_poses[index]
        T_start, T_end = self._tool_poses(shape, pose, displacement)
        goals = self.kinematics.inverse(T_start, rng, count=4, near=state.joint_positions)
        if len(goals) == 0:
            return "no_ik"
        world = self.collision.world(state.object_poses, opening=self.robot.gripper.closed)
        approach = self.arm_planner.plan(state.joint_positions, goals, world, rng)
        if approach.path is None:
            return f"approach_{approach.status}"
        sweep = self._sweep(state, approach.path[-1], T_end)
        if isinstance(sweep, str):
            return sweep
        path = np.stack([pose[:2], pose[:2] + displacement])
        return RearrangementAction(KIND, name, self._motion(approach.path, sweep), path)

    def _tool_poses(self, shape: Shape, pose: Array, displacement: Array) -> tuple[Array, Array]:
        """``T_world_tool`` behind the object, and where the push ends."""
        length = float(np.linalg.norm(displacement))
        direction = np.array([*displacement, 0.0]) / max(length, 1e-9)
        # The arm comes in through the open side and cannot turn its back to it.
        heading = float(np.arctan2(displacement[1], displacement[0]))
        yaw = float(np.clip(heading, -self.options.max_yaw, self.options.max_yaw))
        start = pose[:3] - (shape.footprint_radius + self.options.standoff) * direction
        start[2] = self.problem.scene.workspace.floor + self.options.height  # high pushes tip
        T_start = tool_matrix(start, yaw)
        T_end = tool_matrix(start + (self.options.standoff + length) * direction, yaw)
        return T_start, T_end

    def _sweep(self, state: SceneState, start: Array, T_end: Array) -> Array | str:
        """Configurations (k, dof) of the straight push, or why there are none."""
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

    def _motion(self, approach: Array, sweep: Array) -> Motion:
        """There, through, and back the same way."""
        return Motion(
            (
                self._segment(SegmentKind.TRANSIT, approach, contact_free=True),
                self._segment(SegmentKind.SWEEP, sweep, settle=self.options.settle),
                self._segment(SegmentKind.RETRACT, sweep[::-1]),
            ),
            self.robot.gripper.closed,
        )

    def _segment(
        self, kind: SegmentKind, path: Array, *, contact_free: bool = False, settle: float = 0.0
    ) -> MotionSegment:
        trajectory = time_path(path, self.robot.limits, scale=self.options.speed)
        opening = self.robot.gripper.closed
        return MotionSegment(kind, trajectory, opening, None, contact_free, settle)
