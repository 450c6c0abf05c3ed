"""Executes one motion in one engine's world while the constraints watch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mamo_core.constraints.kernels import largest_gap
from mamo_core.constraints.monitor import ConstraintMonitor
from mamo_core.constraints.recorder import TraceRecorder
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.interfaces.simulated_world import SimulatedWorld
from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.robots.model import GripperModel
from mamo_core.simulation.grip import commanded, in_hand
from mamo_core.types.geometry import Array, IntArray
from mamo_core.types.motion import Motion, MotionSegment
from mamo_core.types.rollout import NO_CONTACTS, RolloutResult, Watch
from mamo_core.types.scene import Scene, SceneState, displacements

MOVED = 0.01
"""An object counts as moved beyond this displacement, m (thesis 5.5.2)."""

LAG, LAG_SECONDS = 0.05, 0.1
"""The arm is stalled once a joint has been this far behind (rad) for this long (s)."""

HOLD_SECONDS, ARRIVED = 0.16, 0.01
"""After a segment the arm gets this long (s) to come this close (rad) to its end."""

REST_SECONDS, REST_SPEED, REST_SPIN = 0.02, 0.004, 0.06
"""Objects rest once they have been this slow (m/s, rad/s) for this long (s)."""


class MotionRun:
    """One motion, from wherever the world stands; ``opening`` (m) and ``held`` are the hand's.

    ``opening`` is what the fingers were told; something between them may keep them from it.
    """

    def __init__(
        self,
        world: SimulatedWorld,
        scene: Scene,
        gripper: GripperModel,
        constraints: Sequence[InteractionConstraint],
        options: RolloutOptions,
        opening: float,
        held: int = -1,
    ) -> None:
        self._world, self._scene, self._gripper = world, scene, gripper
        self._options = options
        self._step = world.time_step
        self.opening, self.held = opening, held
        self._in_hand = held
        self._monitor = ConstraintMonitor(constraints)
        step, count = options.trace_step, len(scene.entities)
        self._recorder = TraceRecorder(step, count) if step is not None else None
        self._stalled = False
        self._time, self._steps, self._late = 0.0, 0, 0
        self._touched = np.zeros((count, count), dtype=np.bool_)

    def execute(self, motion: Motion, state: SceneState) -> RolloutResult:
        """Run to the end or to where the rollout stops; ``state`` is where the world stands."""
        self._record(self.opening, NO_CONTACTS)
        segment_states, segment_times = [], []
        for segment in motion.segments:
            segment_states.append(self._state())
            segment_times.append(self._time)
            if not self._segment(segment):
                break
        final = self._state()
        names = [o.name for o in self._scene.objects]
        return RolloutResult(
            final_state=final,
            violations=tuple(self._monitor.violations),
            moved=tuple(names[i] for i in np.flatnonzero(displacements(state, final) > MOVED)),
            contacts=self._contacts(),
            stalled=self._stalled,
            duration=self._steps * self._step,
            steps=self._steps,
            segment_states=tuple(segment_states),
            segment_times=tuple(segment_times),
            trace=self._recorder.trace() if self._recorder is not None else None,
        )

    def _segment(self, segment: MotionSegment) -> bool:
        """Execute one segment; False if the rollout ends here."""
        self._hold(segment.held)
        self._in_hand = self._place(in_hand(segment))
        told = commanded(segment, self.opening, self._world.squeeze, self._world.pinch)
        trajectory = segment.trajectory
        count = int(np.ceil(trajectory.duration / self._step - 1e-9))
        times = np.arange(1, count + 1, dtype=np.float64) * self._step
        positions, velocities = trajectory.states_at(times)
        openings = np.linspace(self.opening, told, count + 1)[1:]
        drives = self._gripper.drives(openings)
        seen = openings if told == segment.opening else np.maximum(openings, segment.opening)
        if not self._follow(positions, velocities, drives, seen.tolist()):
            return False
        self.opening = told
        return self._arrive(segment) and self._settle(segment)

    def _follow(
        self, positions: Array, velocities: Array, drives: Array, openings: Sequence[float]
    ) -> bool:
        """Execute commands, one a step, the fingers at ``openings``; False if it ends here."""
        done, watch = 0, self._watch()
        while done < len(positions):
            rest = positions[done:], velocities[done:], drives[done:]
            steps = self._world.follow(*rest, watch)
            done += steps
            if not self._look(steps, positions[done - 1], openings[done - 1]):
                return False
        return True

    def _arrive(self, segment: MotionSegment) -> bool:
        """Wait a little for an arm that is behind."""
        end = segment.trajectory.positions[-1]
        self._world.command(end, np.zeros_like(end), self._gripper.drive(self.opening))
        for _ in range(round(HOLD_SECONDS / self._step)):
            if largest_gap(self._world.joint_positions(), end) < ARRIVED:
                break
            self._world.step()
            if not self._look(1, end, segment.opening):
                return False
        return True

    def _settle(self, segment: MotionSegment) -> bool:
        """Wait until the objects rest, at most as long as the segment allows."""
        end, left = segment.trajectory.positions[-1], int(segment.settle / self._step)
        resting, watch = 0, self._watch()
        while left > 0:
            resting = resting + 1 if self._world.at_rest(REST_SPEED, REST_SPIN) else 0
            if resting >= round(REST_SECONDS / self._step):
                break
            steps = self._world.wait(end, left, REST_SPEED, REST_SPIN, watch)
            left -= steps
            if steps > 1:  # between them it was not at rest
                resting = 0
            if not self._look(steps, end, segment.opening):
                return False
        return True

    def _watch(self) -> Watch | None:
        """What the world may pass over until the hand holds something else."""
        limits = self._monitor.limits(self._in_hand)
        if limits is None or self._recorder is not None:
            return None
        return Watch(*limits, LAG, self._touched)

    def _look(self, steps: int, reference: Array, opening: float) -> bool:
        """See the last of some steps, the others were harmless; False if the rollout ends here."""
        self._steps += steps
        for _ in range(steps):  # a product has other digits
            self._time += self._step
        if steps > 1:
            self._monitor.passed()
            self._late = 0
        seen = self._world.observe(self._time, self._in_hand)
        self._touched[seen.contacts[:, 0], seen.contacts[:, 1]] = True
        broken = self._monitor.see(seen)
        if largest_gap(self._world.joint_positions(), reference) > LAG:
            self._late += 1
            self._stalled = self._late * self._step >= LAG_SECONDS - 1e-9
        else:
            self._late = 0
        if self._recorder is not None:
            self._record(opening, seen.contacts)
        return not (self._stalled or (broken and self._options.stop_early))

    def _record(self, opening: float, contacts: IntArray) -> None:
        if self._recorder is not None:
            joints, poses = self._world.joint_positions(), self._world.object_poses()
            self._recorder.see(self._time, joints, opening, poses, contacts)

    def _hold(self, name: str | None) -> None:
        place = self._place(name)
        if place != self.held:
            self._world.hold(place)
            self.held = place

    def _place(self, name: str | None) -> int:
        return -1 if name is None else self._scene.index(name)

    def _state(self) -> SceneState:
        return SceneState(self._world.joint_positions(), self._world.object_poses())

    def _contacts(self) -> frozenset[tuple[str, str]]:
        """Names of the pairs that touched."""
        names: Any = self._scene.entities
        return frozenset((names[a], names[b]) for a, b in np.argwhere(self._touched))
