"""One PyBullet world that the core steps along motions."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from mamo_core.interfaces.simulated_world import SimulatedWorld
from mamo_core.robots.fingers import finger_drives
from mamo_core.types.geometry import Array, IntArray, z_axes
from mamo_core.types.rollout import NO_CONTACTS, NO_DEPTHS, StepObservation
from mamo_core.types.scene import SceneState
from mamo_pybullet.bullet import pybullet
from mamo_pybullet.world import Bodies, WorldIndex, build

_BODY_A, _BODY_B, _DISTANCE = 1, 2, 8
_FRAME_POSITION, _FRAME_ORIENTATION = 4, 5
_LINKAGE_LIMIT = 400.0
"""Of the linkage that keeps finger tips to their fingers, N m."""
_HOLD_FORCE, _HOLD_CORRECTION = 1e4, 1.0
_SLEEP_SPEED, _SLEEP_SPIN, _SLEEP_AFTER = 0.005, 0.05, 0.1
"""Objects slower than this (m/s, rad/s) for this long (s) sleep until something touches them."""


class PyBulletWorld(SimulatedWorld):
    """A world of its own client, built anew at every reset.

    PyBullet's saved states do not continue exactly; a fresh world does.
    """

    exact_snapshots: ClassVar[bool] = False

    def __init__(self, bodies: Bodies) -> None:
        self._bodies = bodies
        self.time_step = bodies.options.time_step
        self._client: int = pybullet.connect(pybullet.DIRECT)
        self._fingers = finger_drives(bodies.arm, _LINKAGE_LIMIT)
        self._finger_efforts = [finger.effort for finger in self._fingers]
        self._poses = np.array(bodies.problem.initial.object_poses)
        self._axes = z_axes(self._poses)
        self._index: WorldIndex | None = None
        self._hand: int | None = None
        self._held = -1
        self._slow: dict[int, int] = {}
        self._asleep: set[int] = set()
        self._velocities, self._spins = np.zeros((2, len(self._poses), 3))

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
        self._hand, self._held = None, -1
        self._slow, self._asleep = dict.fromkeys(self._index.loose, 0), set()
        self._velocities, self._spins = np.zeros((2, len(self._poses), 3))
        self._poses = np.array(state.object_poses)
        self._axes = z_axes(self._poses)
        for i in self._index.loose:
            self._read(i)
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
            targetPositions=[*positions.tolist(), *self._finger_goals(drive)],
            targetVelocities=[*velocities.tolist(), *(0.0 for _ in index.fingers)],
            positionGains=[options.position_gain] * len(joints),
            velocityGains=[1.0] * len(joints),
            forces=[*self._limits(positions, drive), *self._finger_efforts],
            physicsClientId=self._client,
        )

    def _finger_goals(self, drive: float) -> list[float]:
        """Driven fingers go to ``drive``, tips to where the finger is that carries them."""
        if not self._fingers:
            return []
        index = self.index
        states = pybullet.getJointStates(index.robot, index.fingers, physicsClientId=self._client)
        return [
            drive if finger.follows is None else states[finger.follows][0]
            for finger in self._fingers
        ]

    def _limits(self, positions: Array, drive: float) -> list[float]:
        """Most that each servo may give: its effort beside what carries the arm's own weight."""
        index = self.index
        coordinates = np.empty(len(index.moved))
        coordinates[index.moved_arm], coordinates[index.moved_fingers] = positions, drive
        still = [0.0] * len(coordinates)
        weight = pybullet.calculateInverseDynamics(
            index.robot, coordinates.tolist(), still, still, physicsClientId=self._client
        )
        own = np.abs(np.array(weight)[index.moved_arm])
        efforts = self._bodies.options.effort * self._bodies.arm.effort
        limits: list[float] = (efforts + own).tolist()
        return limits

    def step(self) -> None:
        pybullet.stepSimulation(physicsClientId=self._client)

    def observe(self, time: float, held: int) -> StepObservation:
        """Only what is awake is read: calls into the engine are slow."""
        contacts, depths = self._contacts()
        for i in self.index.loose:
            if i not in self._asleep:
                self._read(i)
                if self._bodies.options.sleep:
                    self._let_sleep(i)
        positions, velocities = self._poses[:, :3].copy(), self._velocities.copy()
        axes = self._axes.copy()
        return StepObservation(time, positions, axes, velocities, contacts, depths, held)

    def _read(self, place: int) -> None:
        body = self.index.objects[place]
        position, (x, y, z, w) = pybullet.getBasePositionAndOrientation(
            body, physicsClientId=self._client
        )
        self._poses[place] = (*position, w, x, y, z)
        self._axes[place] = (
            2.0 * (x * z + w * y),
            2.0 * (y * z - w * x),
            1.0 - 2.0 * (x * x + y * y),
        )
        self._velocities[place], self._spins[place] = pybullet.getBaseVelocity(
            body, physicsClientId=self._client
        )

    def _let_sleep(self, place: int) -> None:
        """PyBullet's own rule waits for two seconds, and calls 0.8 m/s slow."""
        slow = (
            place != self._held
            and np.abs(self._velocities[place]).max() < _SLEEP_SPEED
            and np.abs(self._spins[place]).max() < _SLEEP_SPIN
        )
        self._slow[place] = self._slow[place] + 1 if slow else 0
        if self._slow[place] * self.time_step >= _SLEEP_AFTER:
            self._slow[place] = 0
            self._asleep.add(place)
            self._velocities[place] = self._spins[place] = 0.0
            self._set_activity(place, pybullet.ACTIVATION_STATE_SLEEP)

    def _set_activity(self, place: int, activity: int) -> None:
        body = self.index.objects[place]
        pybullet.changeDynamics(body, -1, activationState=activity, physicsClientId=self._client)

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
        return self._poses.copy()

    def at_rest(self, speed: float, spin: float) -> bool:
        slow = np.abs(self._velocities).max() < speed and np.abs(self._spins).max() < spin
        return bool(slow)

    def hold(self, place: int) -> None:
        """A fixed constraint between tool link and object."""
        if self._hand is not None:
            pybullet.removeConstraint(self._hand, physicsClientId=self._client)
            self._hand = None
            self._set_activity(self._held, pybullet.ACTIVATION_STATE_WAKE_UP)
        self._held = place
        if place >= 0:
            self._asleep.discard(place)
            self._set_activity(place, pybullet.ACTIVATION_STATE_WAKE_UP)
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
        pybullet.changeConstraint(
            fixed, maxForce=_HOLD_FORCE, erp=_HOLD_CORRECTION, physicsClientId=client
        )
        return fixed

    def _contacts(self) -> tuple[IntArray, Array]:
        """Pairs (k, 2) that touch, and how deep (k,).

        PyBullet also lists those that merely come close, which wakes them.
        """
        points = pybullet.getContactPoints(physicsClientId=self._client)
        self._wake({(point[_BODY_A], point[_BODY_B]) for point in points})
        entity = self.index.entity
        deepest: dict[tuple[int, int], float] = {}
        for point in points:
            one, other = entity[point[_BODY_A]], entity[point[_BODY_B]]
            pair = (min(one, other), max(one, other))
            if point[_DISTANCE] <= 0.0:
                deepest[pair] = max(deepest.get(pair, 0.0), -point[_DISTANCE])
        if not deepest:
            return NO_CONTACTS, NO_DEPTHS
        pairs = sorted(deepest)
        return np.array(pairs, dtype=np.int64), np.array([deepest[pair] for pair in pairs])

    def _wake(self, near: set[tuple[int, int]]) -> None:
        """The engine wakes what an awake body touches; from then on it is read again."""
        entity = self.index.entity
        moving = {0, *(1 + i for i in self.index.loose if i not in self._asleep)}
        for pair in near:
            one, other = entity[pair[0]], entity[pair[1]]
            if one in moving:
                self._asleep.discard(other - 1)
            if other in moving:
                self._asleep.discard(one - 1)
