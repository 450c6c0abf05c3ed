"""A fast fake of a physics engine: shapes seen from above that push each other out of the way."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mamo_core.constraints.monitor import ConstraintMonitor
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.interfaces.transition_model import RolloutOptions, TransitionModel
from mamo_core.simulation.grip import in_hand
from mamo_core.testing.flatland import Flatland
from mamo_core.types.geometry import Array, invert, matrix_from_pose, pose_from_matrix, z_axes
from mamo_core.types.motion import Motion, MotionSegment
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import (
    NO_CONTACTS,
    ParameterOverrides,
    RolloutResult,
    StepObservation,
    Trace,
)
from mamo_core.types.scene import SceneState, displacements

MOVED = 0.01
"""Objects displaced by more than this count as moved, m."""


@dataclass(frozen=True, eq=False)
class QuasiStaticOptions:
    """``dt``: step, s. ``finger_radius``: m. ``max_force``: the arm stalls above it, N."""

    dt: float = 0.01
    finger_radius: float = 0.01
    max_force: float = 60.0


class QuasiStaticModel(TransitionModel):
    """What it approximates: everything moves infinitely slowly, in the plane.

    The arm is two vertical fingers at the tool, the opening between them; the rest of it touches
    nothing. Contacts have no friction: objects translate along their normals and never turn, tilt,
    fall or slide on; chains of pushed objects resist with the sum of their friction forces on the
    floor. Contacts are those of objects that something pushed. It needs no settling.
    """

    capabilities = frozenset({"exact_continuation", "parameter_overrides"})

    def __init__(
        self,
        problem: Problem,
        tool: Callable[[Array], Array],
        constraints: Sequence[InteractionConstraint] = (),
        options: QuasiStaticOptions | None = None,
    ) -> None:
        """``tool``: ``T_world_tool`` (4, 4) of a configuration (dof,)."""
        self.problem = problem
        self._tool = tool
        self._constraints = tuple(constraints)
        self._options = options or QuasiStaticOptions()

    def rollout(
        self,
        state: SceneState,
        motion: Motion,
        *,
        parameters: ParameterOverrides | None = None,
        options: RolloutOptions | None = None,
        continue_from: Any = None,
    ) -> RolloutResult:
        world = Flatland(self.problem.scene, state.object_poses, parameters or ParameterOverrides())
        if continue_from is not None:
            if not isinstance(continue_from, _Continuation) or continue_from.model is not self:
                raise ValueError("continue_from: not the continuation of a rollout of this model")
            world.pushed.update(continue_from.pushed)
        run = _Run(self, world, state, options or RolloutOptions())
        run.execute(motion)
        return run.result()

    def tool(self, configuration: Array) -> Array:
        """``T_world_tool`` (4, 4) of a configuration (dof,)."""
        return self._tool(configuration)

    @property
    def constraints(self) -> tuple[InteractionConstraint, ...]:
        """What every step is shown to."""
        return self._constraints

    @property
    def options(self) -> QuasiStaticOptions:
        """Step, finger and strength."""
        return self._options


@dataclass(frozen=True, eq=False)
class _Continuation:
    model: QuasiStaticModel
    pushed: frozenset[int]


class _Run:
    """One rollout: the arm moves step by step, the world makes way."""

    def __init__(
        self,
        model: QuasiStaticModel,
        world: Flatland,
        state: SceneState,
        options: RolloutOptions,
    ) -> None:
        self._model, self._world, self._start = model, world, state
        self._options = options
        self._monitor = ConstraintMonitor(model.constraints)
        self._recorder = _Recorder(options.trace_step)
        self._joints = state.joint_positions
        self._time, self._steps = 0.0, 0
        self._touched: set[tuple[int, int]] = set()
        self._segment_states: list[SceneState] = []
        self._stalled = self._done = False

    def execute(self, motion: Motion) -> None:
        opening = motion.opening
        self._recorder.see(0.0, self._joints, opening, self._world.poses)
        for segment in motion.segments:
            if self._done:
                return
            self._joints = segment.trajectory.positions[0]
            self._segment_states.append(self._state())
            self._segment(segment, opening)
            opening = segment.opening

    def _segment(self, segment: MotionSegment, opening: float) -> None:
        duration = segment.trajectory.duration
        count = max(1, round(duration / self._model.options.dt))
        name, scene = in_hand(segment), self._model.problem.scene
        held = -1 if name is None else scene.index(name)
        # What is closed on, or let go of, stays where it is.
        T_tool_held = self._grip(held if segment.held is not None else -1)
        begin = self._time
        for step in range(1, count + 1):
            fraction = step / count
            self._joints = segment.trajectory.at(np.array([fraction * duration]))[0]
            width = opening + fraction * (segment.opening - opening)
            self._step(begin + fraction * duration, width, held, T_tool_held)
            if self._done:
                return

    def _grip(self, held: int) -> Array | None:
        if held < 0:
            return None
        T_world_tool = self._model.tool(self._joints)
        return invert(T_world_tool) @ matrix_from_pose(self._world.poses[held])

    def _step(self, time: float, opening: float, held: int, T_tool_held: Array | None) -> None:
        before = self._world.poses[:, :3].copy()
        T_world_tool = self._model.tool(self._joints)
        if T_tool_held is not None:
            self._world.place(held, pose_from_matrix(T_world_tool @ T_tool_held))
        options = self._model.options
        contacts = self._world.make_way(T_world_tool, opening, options.finger_radius, held)
        self._stalled = self._world.jammed or self._world.resistance() > options.max_force
        elapsed, self._time = time - self._time, time
        self._steps += 1
        self._touched |= contacts
        poses = self._world.poses
        broken = self._monitor.see(
            StepObservation(
                time=time,
                positions=poses[:, :3].copy(),
                z_axes=z_axes(poses),
                velocities=(poses[:, :3] - before) / max(elapsed, 1e-9),
                contacts=np.array(sorted(contacts), dtype=np.int64) if contacts else NO_CONTACTS,
                depths=np.zeros(len(contacts)),
                held=held,
            )
        )
        self._recorder.see(time, self._joints, opening, poses)
        self._done = self._stalled or (broken and self._options.stop_early)

    def _state(self) -> SceneState:
        return SceneState(self._joints, self._world.poses)

    def _continuation(self) -> _Continuation | None:
        if not self._options.keep:
            return None
        return _Continuation(self._model, frozenset(self._world.pushed))

    def result(self) -> RolloutResult:
        """What happened."""
        final = self._state()
        scene = self._model.problem.scene
        shifts = displacements(self._start, final)
        return RolloutResult(
            final_state=final,
            violations=tuple(self._monitor.violations),
            moved=tuple(scene.objects[i].name for i in np.flatnonzero(shifts > MOVED)),
            contacts=frozenset((scene.entities[a], scene.entities[b]) for a, b in self._touched),
            stalled=self._stalled,
            duration=self._time,
            steps=self._steps,
            segment_states=tuple(self._segment_states),
            trace=self._recorder.trace(),
            continuation=self._continuation(),
        )


class _Recorder:
    """Keeps the first step at or after each multiple of ``step`` seconds."""

    def __init__(self, step: float | None) -> None:
        self._step = step
        self._rows: list[tuple[float, Array, float, Array]] = []

    def see(self, time: float, joints: Array, opening: float, poses: Array) -> None:
        while self._step is not None and time >= len(self._rows) * self._step - 1e-9:
            self._rows.append((len(self._rows) * self._step, joints, opening, poses.copy()))

    def trace(self) -> Trace | None:
        if self._step is None:
            return None
        times, joints, openings, poses = (
            np.array(column) for column in zip(*self._rows, strict=True)
        )
        return Trace(times, joints, openings, poses)
