"""One DART world that the core steps along motions."""

from __future__ import annotations

from typing import Any, ClassVar

import dartpy
import numpy as np

from mamo_core.interfaces.simulated_world import SimulatedWorld
from mamo_core.robots.fingers import finger_drives
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, IntArray, matrix_from_pose, pose_from_matrix, z_axes
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import NO_CONTACTS, NO_DEPTHS, ParameterOverrides, StepObservation
from mamo_core.types.scene import SceneState
from mamo_dart.options import DARTOptions
from mamo_dart.world import LINKAGE_LIMIT, build, load_robot, values_of


class DARTWorld(SimulatedWorld):
    """Everything but the arm is built anew at every reset.

    The cone solver starts from its last result and bodies remember how long they have been slow,
    which no snapshot could hold: continuations execute everything again.
    """

    exact_snapshots: ClassVar[bool] = False

    def __init__(
        self,
        problem: Problem,
        arm: ArmModel,
        options: DARTOptions,
        parameters: ParameterOverrides | None,
    ) -> None:
        self._problem, self._arm, self._options = problem, arm, options
        self._values = values_of(problem, parameters)
        self._robot = load_robot(problem, arm, options)
        self._poses = np.array(problem.initial.object_poses)
        self._parts = build(problem, arm, options, self._values, self._robot, self._poses)
        self.time_step = options.time_step
        self._weld: Any = None
        self._contacts, self._depths, self._unseen = NO_CONTACTS, NO_DEPTHS, 0
        carriers = [finger.follows for finger in finger_drives(arm, LINKAGE_LIMIT)]
        self._tips = np.array([n for n, k in enumerate(carriers) if k is not None], dtype=np.int64)
        self._carriers = np.array([k for k in carriers if k is not None], dtype=np.int64)

    def reset(self, state: SceneState, drive: float) -> None:
        self._weld = None
        self._parts.world.removeSkeleton(self._robot)
        self._poses = np.array(state.object_poses)
        made = self._problem, self._arm, self._options, self._values, self._robot, self._poses
        self._parts = parts = build(*made)
        positions = np.zeros(parts.robot.getNumDofs())
        positions[parts.arm], positions[parts.fingers] = state.joint_positions, drive
        _write(parts.robot, positions)
        for place, body in parts.loose.items():
            T = dartpy.math.Isometry3(matrix_from_pose(state.object_poses[place]))
            _write(body.getSkeleton(), dartpy.dynamics.FreeJoint.convertToPositions(T))
        parts.robot.setCommands(np.zeros_like(positions))
        self._contacts, self._depths, self._unseen = NO_CONTACTS, NO_DEPTHS, 0

    def command(self, positions: Array, velocities: Array, drive: float) -> None:
        """Servos get the velocity that closes the gap within the next step."""
        parts = self._parts
        commands, now = np.zeros(parts.robot.getNumDofs()), parts.robot.getPositions()
        commands[parts.arm], commands[parts.fingers] = positions, drive
        # Tips stand as the finger that carries them does.
        commands[parts.fingers[self._tips]] = now[parts.fingers[self._carriers]]
        parts.robot.setCommands((commands - now) / self.time_step)

    def step(self) -> None:
        self._parts.world.step()
        self._unseen += 1

    def observe(self, time: float, held: int) -> StepObservation:
        velocities = np.zeros_like(self._poses[:, :3])
        for place, body in self._parts.loose.items():
            velocities[place] = body.getLinearVelocity()
        poses = self.object_poses()
        if self._unseen >= self._options.contacts_every:
            (self._contacts, self._depths), self._unseen = self._look(), 0
        touching = self._contacts, self._depths
        return StepObservation(time, poses[:, :3], z_axes(poses), velocities, *touching, held)

    def joint_positions(self) -> Array:
        positions: Array = self._parts.robot.getPositions()[self._parts.arm]
        return positions

    def tool_pose(self) -> Array:
        return pose_from_matrix(self._parts.tool.getWorldTransform().matrix())

    def object_poses(self) -> Array:
        poses = self._poses.copy()
        loose = self._parts.loose
        coordinates = np.array([body.getSkeleton().getPositions() for body in loose.values()])
        poses[list(loose)] = poses_of(coordinates.reshape(-1, 6))
        return poses

    def at_rest(self, speed: float, spin: float) -> bool:
        for body in self._parts.loose.values():
            if np.abs(body.getLinearVelocity()).max() >= speed:
                return False
            if np.abs(body.getAngularVelocity()).max() >= spin:
                return False
        return True

    def hold(self, place: int) -> None:
        """A weld between tool link and object."""
        solver = self._parts.world.getConstraintSolver()
        if self._weld is not None:
            solver.removeConstraint(self._weld)
            self._weld = None
        if place >= 0:
            body = self._parts.loose[place]
            self._weld = dartpy.constraint.WeldJointConstraint(body, self._parts.tool)
            solver.addConstraint(self._weld)

    def _look(self) -> tuple[IntArray, Array]:
        """Entity pairs (k, 2), ascending, that touch now, and how deep (k,)."""
        entity = self._parts.entity
        deepest: dict[tuple[int, int], float] = {}
        for contact in self._parts.world.getLastCollisionResult().getContacts():
            one = entity[contact.collisionObject1.getShapeFrame()]
            other = entity[contact.collisionObject2.getShapeFrame()]
            pair = (min(one, other), max(one, other))
            deepest[pair] = max(deepest.get(pair, 0.0), contact.penetrationDepth)
        if not deepest:
            return NO_CONTACTS, NO_DEPTHS
        pairs = sorted(deepest)
        return np.array(pairs, dtype=np.int64), np.array([deepest[pair] for pair in pairs])


def _write(skeleton: Any, positions: Array) -> None:
    skeleton.setPositions(positions)
    skeleton.setVelocities(np.zeros_like(positions))
    skeleton.setAccelerations(np.zeros_like(positions))
    skeleton.setForces(np.zeros_like(positions))


def poses_of(coordinates: Array) -> Array:
    """Poses (m, 7) from the coordinates (m, 6) of free joints: rotation vectors, positions."""
    angles = np.linalg.norm(coordinates[:, :3], axis=1, keepdims=True)
    # sinc(x) is sin(pi x) / (pi x), which has no hole at 0.
    vectors = 0.5 * np.sinc(angles / (2.0 * np.pi)) * coordinates[:, :3]
    return np.hstack([coordinates[:, 3:], np.cos(angles / 2.0), vectors])
