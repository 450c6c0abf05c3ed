"""Fake parts for searches: a gantry that reaches straight in, and pushes along straight lines."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np

from mamo_core.interfaces.action_generator import ActionGenerator, ActionRequest
from mamo_core.interfaces.retrieval import Retrieval, RetrievalPlanner
from mamo_core.problems.footprints import footprint, rectangle, separation
from mamo_core.testing.scenes import HOME, OPENING
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility, SceneState
from mamo_core.types.solution import Statistics

FINGER = 0.01
"""Radius of a finger, as in ``QuasiStaticOptions``, m."""

HALF_WIDTH = OPENING / 2.0 + 2.0 * FINGER
"""Of the way that the open gripper sweeps, m."""

SPEED = 0.2
"""Tool speed, m/s."""

ABOVE = 0.25
"""Height at which the gantry passes over every object, m."""

STAND_OFF = 0.03
"""Gap between finger and object before a push, m."""


class StraightRetrieval(RetrievalPlanner):
    """From home in front of the target straight in along x, grasp, and back the same way."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem

    def plan(
        self,
        state: SceneState,
        rng: np.random.Generator,
        *,
        ignore_movables: bool = False,
        avoid: Collection[int] = (),
    ) -> Retrieval:
        if 0 in avoid:
            return Retrieval(None, causes={"avoided": 1})
        blocking = self._blocking(state, ignore_movables)
        if blocking:
            return Retrieval(None, causes={f"blocked_by_{name}": 1 for name in blocking})
        x, y = self._target(state)
        grasp = np.array([x, y, HOME[2], 0.0])
        beside = np.array([HOME[0], y, HOME[2], 0.0])
        name = self._problem.scene.objects[self._problem.scene.target_index].name
        return Retrieval(
            Motion(
                (
                    _segment(SegmentKind.TRANSIT, [state.joint_positions, beside], OPENING),
                    _segment(SegmentKind.REACH, [beside, grasp], OPENING),
                    _segment(SegmentKind.CARRY, [grasp, beside, HOME], OPENING, held=name),
                ),
                opening=0.0,
            ),
            grasp=0,
        )

    def swept_region(self, state: SceneState, motion: Motion) -> SweptRegion:
        """The way of the fingers, in cells of 1 cm."""
        x, y = self._target(state)
        space = self._problem.scene.workspace
        resolution = 0.01
        origin = np.array([HOME[0], space.lower[1]])
        shape = np.ceil((space.upper[:2] - origin) / resolution - 1e-9).astype(int)
        edges = [origin[axis] + np.arange(shape[axis] + 1) * resolution for axis in (0, 1)]
        along = edges[0][:-1] < x + FINGER
        across = (edges[1][1:] > y - HALF_WIDTH) & (edges[1][:-1] < y + HALF_WIDTH)
        lowest = np.where(along[:, None] & across[None, :], HOME[2] - FINGER, np.inf)
        return SweptRegion(origin, resolution, lowest, space.floor)

    def _target(self, state: SceneState) -> tuple[float, float]:
        x, y = state.object_poses[self._problem.scene.target_index, :2]
        return float(x), float(y)

    def _blocking(self, state: SceneState, ignore_movables: bool) -> list[str]:
        x, y = self._target(state)
        end = x + FINGER
        way = rectangle((HOME[0] + end) / 2.0, y, 0.0, (end - HOME[0]) / 2.0, HALF_WIDTH)
        ignored = {Mobility.TARGET} | ({Mobility.MOVABLE} if ignore_movables else set())
        return [
            item.name
            for item, pose in zip(self._problem.scene.objects, state.object_poses, strict=True)
            if item.mobility not in ignored
            and separation(way, footprint(item.shape, pose)).distance < 0.0
        ]


class StraightPush(ActionGenerator):
    """Pushes from the far side straight to the end of the path; its name is ``push``.

    Without a path it tries 15 cm to the left and to the right.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem

    def propose(
        self,
        state: SceneState,
        request: ActionRequest,
        rng: np.random.Generator,
        statistics: Statistics,
    ) -> Iterator[RearrangementAction]:
        place = self._problem.scene.index(request.object_name)
        start = state.object_poses[place, :2]
        ends = [start + np.array([0.0, 0.15]), start - np.array([0.0, 0.15])]
        for end in ends if request.path is None else [request.path[-1]]:
            length = float(np.linalg.norm(end - start))
            if length < 1e-3:
                statistics.failed(request.object_name, "push", "too_short")
                continue
            motion = self._motion(state, place, (end - start) / length, length)
            path = np.array([start, end]) if request.path is None else request.path
            yield RearrangementAction("push", request.object_name, motion, path)

    def _motion(self, state: SceneState, place: int, direction: Array, length: float) -> Motion:
        item, pose = self._problem.scene.objects[place], state.object_poses[place]
        outline = footprint(item.shape, pose)
        far = rectangle(pose[0] - direction[0], pose[1] - direction[1], 0.0, 1e-9, 1e-9)
        # From one metre behind: the distance to the object tells where its surface is.
        reach = 1.0 - separation(far, outline).distance
        yaw = float(np.arctan2(direction[1], direction[0]))
        behind = pose[:2] - direction * (reach + FINGER + STAND_OFF)
        end = behind + direction * (length + STAND_OFF)
        low = [np.array([*xy, HOME[2], yaw]) for xy in (behind, end)]
        high = [np.array([*xy, ABOVE, yaw]) for xy in (behind, end)]
        home_high = np.array([*HOME[:2], ABOVE, HOME[3]])
        here = state.joint_positions
        here_high = np.array([*here[:2], ABOVE, here[3]])
        return Motion(
            (
                _segment(SegmentKind.TRANSIT, [here, here_high, high[0], low[0]], 0.0),
                _segment(SegmentKind.SWEEP, low, 0.0, contact_free=False),
                _segment(SegmentKind.RETRACT, [low[1], high[1], home_high, HOME], 0.0),
            ),
            opening=0.0,
        )


def _segment(
    kind: SegmentKind,
    stations: Sequence[Array],
    opening: float,
    *,
    held: str | None = None,
    contact_free: bool = True,
) -> MotionSegment:
    """Through the stations at ``SPEED``; turning on the spot takes 0.1 s at least."""
    positions = np.array(stations)
    steps = np.linalg.norm(np.diff(positions[:, :3], axis=0), axis=1)
    times = np.concatenate([[0.0], np.cumsum(np.maximum(steps / SPEED, 0.1))])
    return MotionSegment(kind, Trajectory.through(times, positions), opening, held, contact_free)
