"""The engine: a world that mamo resets, commands, steps and looks at.

To make it yours, put your engine's calls into the methods of ``MyBackend``, above all ``step``.
Everything around them is done by ``mamo_core.simulation``: it executes motions, shows every step to
the constraints, notices an arm that stalls, and records.

What is here is the fast fake of ``mamo_core.testing``. Everything moves infinitely slowly, in the
plane: two fingers push objects aside, chains of objects resist with their friction on the floor,
nothing tips, turns or falls, and the rest of the arm touches nothing.
"""

from __future__ import annotations

from copy import deepcopy
from typing import Any, ClassVar

import numpy as np

from mamo_core.interfaces.simulated_world import SimulatedWorld
from mamo_core.robots.kinematics import link_transforms
from mamo_core.robots.model import ArmModel
from mamo_core.testing.flatland import Flatland
from mamo_core.types.geometry import Array, invert, matrix_from_pose, pose_from_matrix, z_axes
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import NO_CONTACTS, ParameterOverrides, StepObservation
from mamo_core.types.scene import SceneState
from mamo_my_backend.options import MyBackendOptions


class MyBackend(SimulatedWorld):
    """One problem's world; ``parameters``: other masses and frictions than the problem's."""

    exact_snapshots: ClassVar[bool] = True

    def __init__(
        self,
        problem: Problem,
        robot: ArmModel,
        parameters: ParameterOverrides | None,
        options: MyBackendOptions,
    ) -> None:
        self._scene, self._robot, self._options = problem.scene, robot, options
        self._parameters = parameters or ParameterOverrides()
        self._T_world_base = matrix_from_pose(problem.scene.T_world_base)
        self.time_step = options.time_step
        self.reset(problem.initial, robot.gripper.drive(robot.gripper.closed))

    def reset(self, state: SceneState, drive: float) -> None:
        self._flatland = Flatland(self._scene, state.object_poses, self._parameters)
        self._joints, self._drive = state.joint_positions, drive
        self._target = self._joints
        self._held, self._T_tool_held = -1, np.eye(4)
        self._velocities = np.zeros((len(self._scene.objects), 3))
        self._contacts = NO_CONTACTS

    def command(self, positions: Array, velocities: Array, drive: float) -> None:
        """Where the servos should be after the next step."""
        self._target, self._drive = positions, drive

    def step(self) -> None:
        """Move the arm as commanded, unless it cannot go on, and objects out of its way."""
        before, flatland = self._flatland.poses[:, :3].copy(), deepcopy(self._flatland)
        T_world_tool = self._T_world_tool(self._target)
        if self._held >= 0:
            flatland.place(self._held, pose_from_matrix(T_world_tool @ self._T_tool_held))
        pairs = flatland.make_way(
            T_world_tool, self._opening(), self._options.finger_radius, self._held
        )
        self._contacts = np.array(sorted(pairs), dtype=np.int64).reshape(-1, 2)
        if not flatland.jammed and flatland.resistance() <= self._options.max_force:
            self._flatland, self._joints = flatland, self._target
        self._velocities = (self._flatland.poses[:, :3] - before) / self.time_step

    def observe(self, time: float, held: int) -> StepObservation:
        """What the constraints are shown."""
        poses, contacts = self._flatland.poses, self._contacts
        depths = np.zeros(len(contacts))  # nothing is soft here
        return StepObservation(
            time, poses[:, :3].copy(), z_axes(poses), self._velocities, contacts, depths, held
        )

    def joint_positions(self) -> Array:
        return np.array(self._joints)

    def tool_pose(self) -> Array:
        return pose_from_matrix(self._T_world_link(self._joints))

    def object_poses(self) -> Array:
        return self._flatland.poses.copy()

    def at_rest(self, speed: float, spin: float) -> bool:
        """Objects move only while the arm does."""
        return bool((np.abs(self._velocities) < speed).all())

    def hold(self, place: int) -> None:
        """Fix an object to the hand where it is; -1 lets go."""
        self._held = place
        if place >= 0:
            T_world_object = matrix_from_pose(self._flatland.poses[place])
            self._T_tool_held = invert(self._T_world_tool(self._joints)) @ T_world_object

    def snapshot(self) -> Any:
        """Everything that changes."""
        moving = (self._joints, self._target, self._drive, self._held, self._T_tool_held)
        return deepcopy(self._flatland), *moving, self._velocities, self._contacts

    def restore(self, snapshot: Any) -> None:
        flatland, *moving, self._velocities, self._contacts = snapshot
        self._flatland = deepcopy(flatland)
        self._joints, self._target, self._drive, self._held, self._T_tool_held = moving

    def _T_world_link(self, joints: Array) -> Array:
        """``T_world_link`` (4, 4) of the link that carries the hand."""
        links = link_transforms(self._robot, joints, self._opening())
        return self._T_world_base @ links[self._robot.tool_link]

    def _T_world_tool(self, joints: Array) -> Array:
        return self._T_world_link(joints) @ self._robot.T_link_tool

    def _opening(self) -> float:
        """Gap between the fingers, m."""
        openings, drives = self._robot.gripper.drive_of_opening.T
        return float(np.interp(self._drive, drives, openings))
