"""One MuJoCo world that the core steps along motions."""

from __future__ import annotations

from typing import Any, ClassVar

import mujoco
import numpy as np

from mamo_core.interfaces.simulated_world import SimulatedWorld
from mamo_core.robots.fingers import GIVE
from mamo_core.types.geometry import Array, IntArray, invert, matrix_from_pose, pose_from_matrix
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import NO_CONTACTS, NO_DEPTHS, StepObservation, Watch
from mamo_core.types.scene import SceneState
from mamo_mujoco.fingers import FrictionHold
from mamo_mujoco.kernels import at_rest, command, contact_pairs, observe
from mamo_mujoco.loop import Memory, Places, follow, wait
from mamo_mujoco.memory import contacts_of
from mamo_mujoco.world import WorldIndex

_COUNTS = ("time", "ntree_awake", "nbody_awake", "nparent_awake", "nv_awake")
"""What else of ``MjData`` is the state: the time, and how much is awake."""


_READY = -1
"""Of ``MjData.tree_asleep``: counted up to here while a tree is at rest, then it sleeps."""


_BESIDE = 0.0005
"""Fingers stay so far from what is welded to the hand, m."""


class MuJoCoWorld(SimulatedWorld):
    """A compiled model with its data; ``lead`` (s) makes the servos track without lag.

    ``sleep_at_once``: objects that do not begin to move are not watched before they sleep.
    ``pads``: what holds things if there are no welds.
    """

    exact_snapshots: ClassVar[bool] = True
    squeeze: ClassVar[float] = 4.0 * GIVE

    def __init__(
        self,
        problem: Problem,
        model: Any,
        index: WorldIndex,
        lead: float,
        *,
        sleep_at_once: bool = False,
        pads: FrictionHold | None = None,
    ) -> None:
        self._problem, self._model, self._index, self._lead = problem, model, index, lead
        self._data = mujoco.MjData(model)
        self._sleep_at_once = sleep_at_once
        self._place, self._substeps = -1, 1
        self._pads = pads
        # Contacts that hold nothing cost a third of the steps.
        self.pinch = self.squeeze if pads is not None else -_BESIDE
        self.time_step = float(model.opt.timestep)
        self._objects = np.stack([index.bodies, np.full_like(index.bodies, -1)], axis=1)
        self._objects[index.free, 1] = index.free_qvel
        self._seen = np.empty((3, len(index.bodies), 3))
        self._rows = tuple(self._seen)
        self._pose_qpos = index.free_qpos[:, None] + np.arange(7)
        self._fixed = np.setdiff1d(np.arange(len(index.bodies)), index.free)
        self._fixed_poses = problem.initial.object_poses[self._fixed]
        # Views of the engine's memory, which never moves: asking for them costs more than a step.
        data = self._data
        self._qpos, self._qvel, self._ctrl = data.qpos, data.qvel, data.ctrl
        self._xpos, self._xmat = data.xpos, data.xmat
        self._fields = _fields(data)
        self._places = Places(index.arm_qpos, index.free_qvel, self._objects, index.entity)
        self._memory = Memory(
            *(model._address, data._address, self._ctrl, self._qpos, self._qvel),
            *(self._xpos, self._xmat, *contacts_of(data)),
        )

    def reset(self, state: SceneState, drive: float) -> None:
        data, index = self._data, self._index
        # Before the rest: static bodies are put in place when data is reset.
        self._place_fixed(state.object_poses[self._fixed])
        mujoco.mj_resetData(self._model, data)
        self.hold(-1)
        self._qpos[index.arm_qpos] = state.joint_positions
        self._qpos[index.finger_qpos] = drive
        self._qpos[self._pose_qpos] = state.object_poses[index.free]
        self.command(state.joint_positions, np.zeros_like(state.joint_positions), drive)
        mujoco.mj_forward(self._model, data)
        if self._sleep_at_once:
            data.tree_asleep[index.free_trees] = _READY

    def _place_fixed(self, poses: Array) -> None:
        """Immovable objects are bodies of the model: they stand at ``poses`` (k, 7) from now on."""
        bodies = self._index.bodies[self._fixed]
        self._model.body_pos[bodies], self._model.body_quat[bodies] = poses[:, :3], poses[:, 3:]
        self._fixed_poses = poses

    def command(self, positions: Array, velocities: Array, drive: float) -> None:
        """The servos see the position that is due a little later, so that they do not lag."""
        command(self._ctrl, positions, velocities, self._lead, drive)

    def step(self) -> None:
        mujoco.mj_step(self._model, self._data, self._substeps)

    def observe(self, time: float, held: int) -> StepObservation:
        observe(self._xpos, self._xmat, self._qvel, self._objects, self._seen)
        # Three small copies take less time than room for one that is large.
        positions, axes, velocities = self._rows
        some = self._data.ncon > 0
        contacts = self._contacts() if some else NO_CONTACTS
        depths = -self._data.contact.dist if some else NO_DEPTHS
        return StepObservation(
            time, positions.copy(), axes.copy(), velocities.copy(), contacts, depths, held
        )

    def _contacts(self) -> IntArray:
        geoms = self._data.contact.geom
        pairs = np.empty(geoms.shape, dtype=np.int64)
        contact_pairs(geoms, self._index.entity, pairs)
        return pairs

    def joint_positions(self) -> Array:
        return self._qpos.take(self._index.arm_qpos)

    def efforts(self) -> Array:
        """What the arm's servos gave in the last step (dof,), N m or N."""
        return self._data.qfrc_actuator.take(self._index.arm_qvel)

    def tool_pose(self) -> Array:
        return pose_from_matrix(_body_matrix(self._data, self._index.tool_body))

    def object_poses(self) -> Array:
        poses = np.empty((len(self._index.bodies), 7))
        poses[self._index.free] = self._qpos[self._pose_qpos]
        poses[self._fixed] = self._fixed_poses
        return poses

    def at_rest(self, speed: float, spin: float) -> bool:
        return at_rest(self._qvel, self._index.free_qvel, speed, spin)

    def hold(self, place: int) -> None:
        """Weld the object to the tool link, unless the fingers have to hold it."""
        welds = self._index.welds
        self._data.eq_active[welds[welds >= 0]] = 0
        self._place = place
        if self._pads is not None:
            self._substeps = self._pads.hold(place)
            return
        if place < 0:
            return
        weld = int(welds[place])
        tool, item = self._index.tool_body, self._index.bodies[place]
        T = invert(_body_matrix(self._data, tool)) @ _body_matrix(self._data, item)
        self._model.eq_data[weld, :3] = 0.0
        self._model.eq_data[weld, 3:10] = pose_from_matrix(T)
        self._data.eq_active[weld] = 1

    def follow(
        self, positions: Array, velocities: Array, drives: Array, watch: Watch | None
    ) -> int:
        if watch is None or self._substeps > 1:
            return super().follow(positions, velocities, drives, watch)
        commands = positions, velocities, drives
        return follow(self._memory, self._places, watch, self._seen, *commands, self._lead)

    def wait(self, end: Array, steps: int, speed: float, spin: float, watch: Watch | None) -> int:
        if watch is None or self._substeps > 1:
            return super().wait(end, steps, speed, spin, watch)
        return wait(self._memory, self._places, watch, self._seen, end, steps, speed, spin)

    def snapshot(self) -> Any:
        """All that a step begins with; a copy of ``MjData`` takes far more memory and time."""
        counts = [getattr(self._data, name) for name in _COUNTS]
        fields = [field.copy() for field in self._fields]
        return fields, counts, self._model.eq_data.copy(), self._fixed_poses, self._place

    def restore(self, snapshot: Any) -> None:
        fields, counts, welds, fixed_poses, place = snapshot
        self._place_fixed(fixed_poses)
        self._place = place
        if self._pads is not None:
            self._substeps = self._pads.hold(place)
        for field, values in zip(self._fields, fields, strict=True):
            field[...] = values
        for name, value in zip(_COUNTS, counts, strict=True):
            setattr(self._data, name, value)
        self._model.eq_data[:] = welds


def _fields(data: Any) -> list[Any]:
    """The arrays of new data that hold something.

    What depends on contacts is still empty: it lies in the arena, and every step makes it anew.
    """
    values = (getattr(data, name) for name in dir(data) if not name.startswith("_"))
    return [value for value in values if isinstance(value, np.ndarray) and value.size]


def _body_matrix(data: Any, body: int) -> Array:
    return matrix_from_pose(np.concatenate([data.xpos[body], data.xquat[body]]))
