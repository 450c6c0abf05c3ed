"""Steps one MuJoCo world along a motion while the constraints watch."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from mamo_core.constraints.monitor import ConstraintMonitor
from mamo_core.constraints.recorder import TraceRecorder
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, invert, matrix_from_pose, pose_from_matrix
from mamo_core.types.motion import Motion, MotionSegment
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import NO_CONTACTS, RolloutResult, StepObservation
from mamo_core.types.scene import SceneState, displacements
from mamo_mujoco.kernels import at_rest, contact_pairs, largest_gap, observe
from mamo_mujoco.world import WorldIndex

MOVED = 0.01
"""An object counts as moved beyond this displacement, m (thesis 5.5.2)."""
_LAG, _LAG_STEPS = 0.05, 25
_HOLD_STEPS, _ARRIVED = 40, 0.01
_REST_STEPS, _REST_SPEED, _REST_SPIN = 5, 0.004, 0.06


@dataclass(frozen=True, eq=False)
class Continuation:
    """A copy of the engine's whole state, for exact continuation."""

    data: Any
    opening: float
    held: int
    welds: Any


class Engine:
    """One compiled model with its data; used by one thread at a time."""

    def __init__(
        self,
        problem: Problem,
        arm: ArmModel,
        model: Any,
        index: WorldIndex,
        constraints: tuple[InteractionConstraint, ...],
        lead: float,
    ) -> None:
        self._problem, self._arm, self._model, self._index = problem, arm, model, index
        self._constraints, self._lead = constraints, lead
        self._data = mujoco.MjData(model)
        self._step = float(model.opt.timestep)
        # Views of the engine's memory, which never moves: asking for them costs more than a step.
        data = self._data
        self._qpos, self._qvel, self._ctrl = data.qpos, data.qvel, data.ctrl
        self._xpos, self._xmat = data.xpos, data.xmat

    def run(
        self,
        state: SceneState,
        motion: Motion,
        options: RolloutOptions,
        continuation: Continuation | None,
        keep: bool,
    ) -> RolloutResult:
        """Execute ``motion``; ``keep`` asks for a continuation in the result."""
        self._begin(state, motion, options, continuation)
        segment_states = []
        for segment in motion.segments:
            segment_states.append(self._state())
            if not self._segment(segment):
                break
        final = self._state()
        moved = displacements(state, final) > MOVED
        names = [o.name for o in self._problem.scene.objects]
        return RolloutResult(
            final_state=final,
            violations=tuple(self._monitor.violations),
            moved=tuple(names[i] for i in np.flatnonzero(moved)),
            contacts=self._contacts(),
            stalled=self._stalled,
            duration=self._steps * self._step,
            steps=self._steps,
            segment_states=tuple(segment_states),
            trace=self._recorder.trace() if self._recorder is not None else None,
            continuation=(self._continuation() if keep else None),
        )

    def _begin(
        self,
        state: SceneState,
        motion: Motion,
        options: RolloutOptions,
        continuation: Continuation | None,
    ) -> None:
        self._options = options
        self._monitor = ConstraintMonitor(self._constraints)
        self._stalled, self._stop = False, False
        self._steps, self._late, self._held = 0, 0, -1
        entities = len(self._problem.scene.entities)
        self._touched = np.zeros((entities, entities), dtype=np.bool_)
        step = options.trace_step
        self._recorder = TraceRecorder(step) if step is not None else None
        if continuation is not None:
            mujoco.mj_copyData(self._data, self._model, continuation.data)
            self._opening, self._held = continuation.opening, continuation.held
            self._model.eq_data[:] = continuation.welds
        else:
            self._opening = motion.opening
            self._write(state, motion.opening)
        self._time = 0.0
        self._record(self._opening)

    def _write(self, state: SceneState, opening: float) -> None:
        data, index = self._data, self._index
        mujoco.mj_resetData(self._model, data)
        self._qpos[index.arm_qpos] = state.joint_positions
        self._qpos[index.finger_qpos] = self._arm.gripper.drive(opening)
        for number, address in zip(index.free, index.free_qpos, strict=True):
            self._qpos[address : address + 7] = state.object_poses[number]
        self._command(state.joint_positions, self._arm.gripper.drive(opening))
        mujoco.mj_forward(self._model, data)

    def _command(self, target: Array, drive: float) -> None:
        self._ctrl[: target.size] = target
        self._ctrl[target.size :] = drive

    def _segment(self, segment: MotionSegment) -> bool:
        """Execute one segment; False if the rollout ends here."""
        self._hold(segment.held)
        trajectory = segment.trajectory
        count = int(np.ceil(trajectory.duration / self._step - 1e-9))
        times = np.arange(1, count + 1, dtype=np.float64) * self._step
        positions = trajectory.at(times)
        before = np.vstack([trajectory.positions[:1], positions[:-1]])
        targets = positions + self._lead * (positions - before) / self._step
        openings = np.linspace(self._opening, segment.opening, count + 1)[1:]
        drives = [self._arm.gripper.drive(opening) for opening in openings]
        for k in range(count):
            self._command(targets[k], drives[k])
            self._advance(positions[k], openings[k])
            if self._stop:
                return False
        self._opening = segment.opening
        end = trajectory.positions[-1]
        self._command(end, self._arm.gripper.drive(segment.opening))
        for _ in range(_HOLD_STEPS):
            if self._error(end) < _ARRIVED:
                break
            self._advance(end, segment.opening)
            if self._stop:
                return False
        return self._settle(end, segment)

    def _settle(self, end: Array, segment: MotionSegment) -> bool:
        """Wait until the objects rest, at most as long as the segment allows."""
        resting = 0
        for _ in range(int(segment.settle / self._step)):
            resting = resting + 1 if self._at_rest() else 0
            if resting >= _REST_STEPS:
                break
            self._advance(end, segment.opening)
            if self._stop:
                return False
        return True

    def _advance(self, reference: Array, opening: float) -> None:
        mujoco.mj_step(self._model, self._data)
        self._steps += 1
        self._time += self._step
        broken = self._monitor.see(self._observe())
        if broken and self._options.stop_early:
            self._stop = True
        self._late = self._late + 1 if self._error(reference) > _LAG else 0
        if self._late >= _LAG_STEPS:
            self._stalled = self._stop = True
        self._record(opening)

    def _record(self, opening: float) -> None:
        if self._recorder is not None:
            joints = self._qpos[self._index.arm_qpos]
            self._recorder.see(self._time, joints, opening, self._poses())

    def _observe(self) -> StepObservation:
        data, index = self._data, self._index
        positions, axes, velocities = observe(
            self._xpos, self._xmat, self._qvel, index.bodies, index.free, index.free_qvel
        )
        contacts = NO_CONTACTS
        if data.ncon:
            contacts = contact_pairs(data.contact.geom, index.entity, self._touched)
        return StepObservation(self._time, positions, axes, velocities, contacts, self._held)

    def _error(self, reference: Array) -> float:
        return largest_gap(self._qpos, self._index.arm_qpos, reference)

    def _at_rest(self) -> bool:
        return at_rest(self._qvel, self._index.free_qvel, _REST_SPEED, _REST_SPIN)

    def _hold(self, name: str | None) -> None:
        """Weld the object to the tool where it is now, or let go."""
        if name is None:
            if self._held >= 0:
                self._data.eq_active[:] = 0
                self._held = -1
            return
        number = self._problem.scene.index(name)
        if number == self._held:
            return
        self._data.eq_active[:] = 0
        weld = self._model.equality(f"hold:{name}").id
        tool, item = self._index.tool_body, self._index.bodies[number]
        T = invert(_body_matrix(self._data, tool)) @ _body_matrix(self._data, item)
        pose = pose_from_matrix(T)
        self._model.eq_data[weld, :3] = 0.0
        self._model.eq_data[weld, 3:10] = pose
        self._data.eq_active[weld] = 1
        self._held = number

    def _continuation(self) -> Continuation:
        welds = self._model.eq_data.copy()
        return Continuation(copy.copy(self._data), self._opening, self._held, welds)

    def _poses(self) -> Array:
        poses = np.array(self._problem.initial.object_poses)
        index = self._index
        for number, address in zip(index.free, index.free_qpos, strict=True):
            poses[number] = self._qpos[address : address + 7]
        return poses

    def _state(self) -> SceneState:
        return SceneState(self._qpos[self._index.arm_qpos], self._poses())

    def _contacts(self) -> frozenset[tuple[str, str]]:
        names = self._problem.scene.entities
        return frozenset((names[a], names[b]) for a, b in np.argwhere(self._touched))


def _body_matrix(data: Any, body: int) -> Array:
    return matrix_from_pose(np.concatenate([data.xpos[body], data.xquat[body]]))
