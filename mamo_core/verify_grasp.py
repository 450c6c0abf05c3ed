"""Whether what a plan carries is in the hand: fingers closed on it, on both sides, firmly enough.

A hold is the stretch of segments in which one object is attached to the tool. Just before it the
fingers close on the object while the arm stands still, and just after it, unless the motion ends,
they let go in the same way.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mamo_core.robots.exact_collision import ExactChecker
from mamo_core.robots.grip import grip_fault
from mamo_core.robots.kinematics import finger_transforms, tool_transform
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, invert, matrix_from_pose
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind
from mamo_core.types.problem import Problem
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Plan

_STILL = 1e-6
"""The arm moves less than this while the fingers close, rad."""

_OFF = 0.002
"""How far an object may be off the middle between the fingers, m: engines push it a little when it
is pressed. On each side the gap that is held must be too small with so much less, and free with so
much more."""

_SAME_GAP = 1e-6

_FAULTS = {
    "grip_missed": "the pads of the fingers are beside it",
    "grip_too_weak": "friction does not carry its weight",
    "grip_would_turn": "its weight would turn it between the fingers",
}


@dataclass(frozen=True)
class Hold:
    """``first`` and ``last``: numbers of the segments that hold object ``name``."""

    name: str
    first: int
    last: int


def holds(segments: Sequence[MotionSegment]) -> Iterator[Hold]:
    """Stretches of segments that hold the same object, one after the other."""
    first = 0
    while first < len(segments):
        last, name = first, segments[first].held
        while last + 1 < len(segments) and segments[last + 1].held == name:
            last += 1
        if name is not None:
            yield Hold(name, first, last)
        first = last + 1


def check_handling(plan: Plan) -> list[str]:
    """Closing and letting go happen where they should in each motion, and nowhere else."""
    failures = []
    for number, motion in enumerate(plan.motions):
        failures += [f"motion {number}: {text}" for text in _handling(motion)]
    return failures


def _handling(motion: Motion) -> Iterator[str]:
    segments = motion.segments
    openings = [motion.opening, *(segment.opening for segment in segments)]
    due: dict[int, str] = {}
    for hold in holds(segments):
        due[hold.first - 1] = hold.name
        gaps = openings[hold.first : hold.last + 2]
        if max(gaps) - min(gaps) > _SAME_GAP:
            yield f"the fingers move while they hold {hold.name!r}"
        if hold.last + 1 < len(segments):
            due[hold.last + 1] = hold.name
            if openings[hold.last + 2] <= gaps[0]:
                yield f"the fingers do not open to let go of {hold.name!r}"
        if hold.first == 0 or openings[hold.first - 1] <= gaps[0]:
            yield f"the fingers do not close on {hold.name!r} before it is held"
    for number, segment in enumerate(segments):
        if segment.closes_on != due.get(number):
            wrong = segment.closes_on if segment.closes_on is not None else due[number]
            yield f"{segment.kind}: the fingers must close on {wrong!r}, or let go of it, just then"
        elif segment.closes_on is not None and not _stands(segment):
            yield f"{segment.kind}: the arm must stand still while the fingers move"


def _stands(segment: MotionSegment) -> bool:
    positions = segment.trajectory.positions
    still = np.abs(positions - positions[0]).max() <= _STILL
    return segment.kind is SegmentKind.GRIPPER and bool(still) and segment.held is None


def check_fingers(
    problem: Problem,
    segments: Sequence[MotionSegment],
    states: Sequence[SceneState],
    robot: ArmModel,
    opening: float,
) -> list[str]:
    """Every hold is by fingers that have closed on the object, on both sides, on exact meshes.

    ``opening`` (m): the gripper's before the first segment; ``states``: one for the start of each
    segment. Before they close the fingers must not touch the object, afterwards a gap a little
    smaller than the one that is held must be too small on both sides, and one a little larger on
    none; and friction there must carry the object.
    """
    failures = []
    before = [opening, *(segment.opening for segment in segments)]
    for hold in holds(segments):
        closing, first = max(hold.first - 1, 0), hold.first
        segment, held_gap = segments[first], before[first]
        near = _Near(problem, robot, hold.name, segment.trajectory.positions[0])
        text = f"{segment.kind}: the fingers "
        if near.sides(states[closing], before[closing]):
            failures.append(f"{text}touch {hold.name!r} before they close on it")
        if near.sides(states[first], held_gap - 2.0 * _OFF) != {-1, 1}:
            failures.append(f"{text}do not close on {hold.name!r} from both sides")
        elif near.sides(states[first], held_gap + 2.0 * _OFF):
            failures.append(f"{text}are said to be closer than {hold.name!r} lets them")
        else:
            fault = near.fault(states[first], held_gap)
            if fault is not None:
                failures.append(f"{segment.kind}: {hold.name!r} cannot be held: {_FAULTS[fault]}")
    return failures


class _Near:
    """One object and the hand that holds it, the arm at ``q`` (dof,)."""

    def __init__(self, problem: Problem, robot: ArmModel, name: str, q: Array) -> None:
        self._problem, self._robot, self._q = problem, robot, q
        self._place = problem.scene.index(name)
        self._others = [item for item in problem.scene.entities[1:] if item != name]
        self._checker = ExactChecker(problem.scene, robot)

    def sides(self, state: SceneState, opening: float) -> set[int]:
        """Sides of the hand, -1 and 1, whose fingers touch the object, ``opening`` (m) apart."""
        world = self._checker.world(state.object_poses, opening=opening, ignore=self._others)
        side = finger_sides(self._robot)
        return {side[link] for link in world.touching_links(self._q) if link in side}

    def fault(self, state: SceneState, width: float) -> str | None:
        """Why friction would not carry the object."""
        T_world_tool = matrix_from_pose(self._problem.scene.T_world_base) @ tool_transform(
            self._robot, self._q
        )
        T = invert(T_world_tool) @ matrix_from_pose(state.object_poses[self._place])
        return grip_fault(self._problem.scene.objects[self._place], T, width, self._robot)


def finger_sides(robot: ArmModel) -> dict[int, int]:
    """Which side of the tool each finger link is on: 1 for its positive y axis, or -1."""
    gripper = robot.gripper
    T_tool_link = invert(robot.T_link_tool)
    placed = finger_transforms(robot.links, gripper.drive(gripper.max_opening))
    centres = {
        number: (T_tool_link @ T @ [*robot.links[number].center_of_mass, 1.0])[1]
        for number, T in placed.items()
    }
    return {number: 1 if y > 0.0 else -1 for number, y in centres.items()}
