"""One MuJoCo world that the core steps along motions."""

from __future__ import annotations

from typing import Any, ClassVar

import mujoco
import numpy as np

from mamo_core.interfaces.simulated_world import SimulatedWorld
from mamo_core.types.geometry import Array, IntArray, invert, matrix_from_pose, pose_from_matrix
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import NO_CONTACTS, StepObservation, Watch
from mamo_core.types.scene import SceneState
from mamo_mujoco.kernels import at_rest, command, contact_pairs, observe
from mamo_mujoco.loop import Memory, Places, follow, wait
from mamo_mujoco.memory import contacts_of
from mamo_mujoco.world import WorldIndex

_COUNTS = ("time", "ntree_awake", "nbody_awake", "nparent_awake", "nv_awake")
"""What else of ``MjData`` is the state: the time, and how much is awake."""


_READY = -1
"""Of ``MjData.tree_asleep``: counted up to here while a tree is at rest, then it sleeps."""


class MuJoCoWorld(SimulatedWorld):
    """A compiled model with its data; ``lead`` (s) makes the servos track without lag.

    ``sleep_at_once``: objects that do not begin to move are not watched before they sleep.
    """

    exact_snapshots: ClassVar[bool] = True

    def __init__(
        self,
        problem: Problem,
        model: Any,
        index: WorldIndex,
        lead: float,
        *,
        sleep_at_once: bool = False,
    ) -> None:
        self._problem, self._model, self._index, self._lead = problem, model, index, lead
        self._data = mujoco.MjData(model)
        self._sleep_at_once = sleep_at_once
        self.time_step = float(model.opt.timestep)
        self._objects = np.stack([index.bodies, np.full_like(index.bodies, -1)], axis=1)
        self._objects[index.free, 1] = index.free_qvel
        self._seen = np.empty((3, len(index.bodies), 3))
        self._rows = tuple(self._seen)
        self._pose_qpos = index.free_qpos[:, None] + np.arange(7)
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
        mujoco.mj_resetData(self._model, data)
        self._qpos[index.arm_qpos] = state.joint_positions
        self._qpos[index.finger_qpos] = drive
        self._qpos[self._pose_qpos] = state.object_poses[index.free]
        self.command(state.joint_positions, np.zeros_like(state.joint_positions), drive)
        mujoco.mj_forward(self._model, data)
        if self._sleep_at_once:
            data.tree_asleep[index.free_trees] = _READY

    def command(self, positions: Array, velocities: Array, drive: float) -> None:
        """The servos see the position that is due a little later, so that they do not lag."""
        command(self._ctrl, positions, velocities, self._lead, drive)

    def step(self) -> None:
        mujoco.mj_step(self._model, self._data)

    def observe(self, time: float, held: int) -> StepObservation:
        observe(self._xpos, self._xmat, self._qvel, self._objects, self._seen)
        # Three small copies take less time than room for one that is large.
        positions, axes, velocities = self._rows
        contacts = self._contacts() if self._data.ncon else NO_CONTACTS
        return StepObservation(
            time, positions.copy(), axes.copy(), velocities.copy(), contacts, held
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
        poses = np.array(self._problem.initial.object_poses)
        poses[self._index.free] = self._qpos[self._pose_qpos]
        return poses

    def at_rest(self, speed: float, spin: float) -> bool:
        return at_rest(self._qvel, self._index.free_qvel, speed, spin)

    def hold(self, place: int) -> None:
        """Weld the object to the tool link."""
        self._data.eq_active[:] = 0
        if place < 0:
            return
        name = self._problem.scene.objects[place].name
        weld = self._model.equality(f"hold:{name}").id
        tool, item = self._index.tool_body, self._index.bodies[place]
        T = invert(_body_matrix(self._data, tool)) @ _body_matrix(self._data, item)
        self._model.eq_data[weld, :3] = 0.0
        self._model.eq_data[weld, 3:10] = pose_from_matrix(T)
        self._data.eq_active[weld] = 1

    def follow(
        self, positions: Array, velocities: Array, drives: Array, watch: Watch | None
    ) -> int:
        if watch is None:
            return super().follow(positions, velocities, drives, watch)
        commands = positions, velocities, drives
        return follow(self._memory, self._places, watch, self._seen, *commands, self._lead)

    def wait(self, end: Array, steps: int, speed: float, spin: float, watch: Watch | None) -> int:
        if watch is None:
            return super().wait(end, steps, speed, spin, watch)
        return wait(self._memory, self._places, watch, self._seen, end, steps, speed, spin)

    def snapshot(self) -> Any:
        """All that a step begins with; a copy of ``MjData`` takes far more memory and time."""
        counts = [getattr(self._data, name) for name in _COUNTS]
        return [field.copy() for field in self._fields], counts, self._model.eq_data.copy()

    def restore(self, snapshot: Any) -> None:
        fields, counts, welds = snapshot
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
