"""One PyBullet world that the core steps along motions."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pybullet

from mamo_core.interfaces.simulated_world import SimulatedWorld
from mamo_core.types.geometry import Array, IntArray, z_axes
from mamo_core.types.rollout import NO_CONTACTS, StepObservation
from mamo_core.types.scene import SceneState
from mamo_pybullet.world import Bodies, WorldIndex, build

_BODY_A, _BODY_B, _DISTANCE = 1, 2, 8
_FRAME_POSITION, _FRAME_ORIENTATION = 4, 5
_HOLD_FORCE = 1e4


class PyBulletWorld(SimulatedWorld):
    """A world of its own client, built anew at every reset.

    PyBullet's saved states do not continue exactly; a fresh world does.
    """

    exact_snapshots: ClassVar[bool] = False

    def __init__(self, bodies: Bodies) -> None:
        self._bodies = bodies
        self.time_step = bodies.options.time_step
        self._client: int = pybullet.connect(pybullet.DIRECT)
        self._poses = np.array(bodies.problem.initial.object_poses)
        self._index: WorldIndex | None = None
        self._hand: int | None = None

    def __del__(self) -> None:
        if pybullet.isConnected(self._client):
            pybullet.disconnect(physicsClientId=self._client)

    @property
    def index(self) -> WorldIndex:
        """Where things are in the present world.

        Raises:
            RuntimeError: there is none before the first reset.
        """
        if self._index is None:
            raise RuntimeError("the world is empty before its first reset")
        return self._index

    def reset(self, state: SceneState, drive: float) -> None:
        self._index = build(self._bodies, state, self._client)
        self._hand = None
        self._poses = np.array(self._bodies.problem.initial.object_poses)
        index = self._index
        goals = [*state.joint_positions.tolist(), *(drive for _ in index.fingers)]
        for joint, position in zip((*index.arm, *index.fingers), goals, strict=True):
            pybullet.resetJointState(index.robot, joint, position, physicsClientId=self._client)
        self.command(state.joint_positions, np.zeros_like(state.joint_positions), drive)

    def command(self, positions: Array, velocities: Array, drive: float) -> None:
        index, options = self.index, self._bodies.options
        joints = (*index.arm, *index.fingers)
        pybullet.setJointMotorControlArray(
            index.robot,
            joints,
            pybullet.POSITION_CONTROL,
            targetPositions=[*positions.tolist(), *(drive for _ in index.fingers)],
            targetVelocities=[*velocities.tolist(), *(0.0 for _ in index.fingers)],
            positionGains=[options.position_gain] * len(joints),
            velocityGains=[1.0] * len(joints),
            forces=[options.torque_limit] * len(joints),
            physicsClientId=self._client,
        )

    def step(self) -> None:
        pybullet.stepSimulation(physicsClientId=self._client)

    def observe(self, time: float, held: int) -> StepObservation:
        velocities = np.zeros((len(self.index.objects), 3))
        for i in self.index.loose:
            velocities[i] = self._velocity(i)[0]
        poses = self.object_poses()
        return StepObservation(
            time, poses[:, :3], z_axes(poses), velocities, self._contacts(), held
        )

    def joint_positions(self) -> Array:
        states = pybullet.getJointStates(
            self.index.robot, self.index.arm, physicsClientId=self._client
        )
        return np.array([state[0] for state in states])

    def tool_pose(self) -> Array:
        state = pybullet.getLinkState(
            self.index.robot,
            self.index.tool,
            computeForwardKinematics=1,
            physicsClientId=self._client,
        )
        x, y, z, w = state[_FRAME_ORIENTATION]
        return np.array([*state[_FRAME_POSITION], w, x, y, z])

    def object_poses(self) -> Array:
        poses = self._poses.copy()
        for i in self.index.loose:
            position, (x, y, z, w) = pybullet.getBasePositionAndOrientation(
                self.index.objects[i], physicsClientId=self._client
            )
            poses[i] = (*position, w, x, y, z)
        return poses

    def at_rest(self, speed: float, spin: float) -> bool:
        for i in self.index.loose:
            velocity, turning = self._velocity(i)
            if max(map(abs, velocity)) >= speed or max(map(abs, turning)) >= spin:
                return False
        return True

    def hold(self, place: int) -> None:
        """A fixed constraint between tool link and object."""
        if self._hand is not None:
            pybullet.removeConstraint(self._hand, physicsClientId=self._client)
            self._hand = None
        if place >= 0:
            self._hand = self._fix(self.index.objects[place])

    def _fix(self, body: int) -> int:
        robot, tool, client = self.index.robot, self.index.tool, self._client
        state = pybullet.getLinkState(
            robot, tool, computeForwardKinematics=1, physicsClientId=client
        )
        # The constraint's frames are relative to the centres of mass.
        to_link = pybullet.invertTransform(state[0], state[1])
        there = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)
        position, orientation = pybullet.multiplyTransforms(*to_link, *there)
        fixed: int = pybullet.createConstraint(
            robot,
            tool,
            body,
            -1,
            pybullet.JOINT_FIXED,
            [0.0, 0.0, 0.0],
            position,
            [0.0, 0.0, 0.0],
            orientation,
            [0.0, 0.0, 0.0, 1.0],
            physicsClientId=client,
        )
        pybullet.changeConstraint(fixed, maxForce=_HOLD_FORCE, physicsClientId=client)
        return fixed

    def _velocity(self, place: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
        linear, angular = pybullet.getBaseVelocity(
            self.index.objects[place], physicsClientId=self._client
        )
        return linear, angular

    def _contacts(self) -> IntArray:
        """Pairs that touch; PyBullet also lists those that merely come close."""
        entity = self.index.entity
        pairs = {
            (entity[point[_BODY_A]], entity[point[_BODY_B]])
            for point in pybullet.getContactPoints(physicsClientId=self._client)
            if point[_DISTANCE] <= 0.0
        }
        ascending = sorted((min(pair), max(pair)) for pair in pairs if pair[0] != pair[1])
        return np.array(ascending, dtype=np.int64) if ascending else NO_CONTACTS
