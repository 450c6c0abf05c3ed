"""What the arm executes: timed joint trajectories in labelled segments."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from mamo_core.types.geometry import Array, frozen_array


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Joint positions (k, dof) rad and velocities (k, dof) rad/s at ``times`` (k,) s from 0 on.

    In between each joint follows the cubic that has both at both ends (Hermite).
    """

    times: Array
    positions: Array
    velocities: Array

    def __post_init__(self) -> None:
        times = frozen_array(self.times, "trajectory times", (None,))
        positions = frozen_array(self.positions, "trajectory positions", (None, None))
        velocities = frozen_array(self.velocities, "trajectory velocities", positions.shape)
        if times.size != positions.shape[0] or times.size == 0:
            raise ValueError(f"trajectory: {times.size} times for {positions.shape[0]} positions")
        if times[0] != 0.0 or (np.diff(times) <= 0.0).any():
            raise ValueError("trajectory: times must start at 0 and increase")
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "positions", positions)
        object.__setattr__(self, "velocities", velocities)

    @classmethod
    def still(cls, configuration: Array, seconds: float) -> Trajectory:
        """The arm stays at a configuration (dof,) for ``seconds``, which may be 0."""
        rows = 2 if seconds > 0.0 else 1
        times = np.array([0.0, seconds])[:rows]
        positions = np.stack([configuration] * rows)
        return cls(times, positions, np.zeros_like(positions))

    @classmethod
    def through(cls, times: Array, positions: Array) -> Trajectory:
        """From rest through ``positions`` (k, dof) at ``times`` (k,) to rest, overshooting nowhere.

        Limits of the arm are not looked at: ``robots.timing.time_path`` finds times for those.
        """
        times = np.asarray(times, dtype=np.float64)
        positions = np.asarray(positions, dtype=np.float64)
        slopes = np.diff(positions, axis=0) / np.diff(times)[:, None]
        before, after = slopes[:-1], slopes[1:]
        # Monotone between rows: no more than twice the smaller slope, and 0 at a turning point.
        least = np.minimum(np.abs(before), np.abs(after))
        inner = np.clip((before + after) / 2.0, -2.0 * least, 2.0 * least)
        velocities = np.zeros_like(positions)
        velocities[1:-1] = np.where(before * after > 0.0, inner, 0.0)
        return cls(times, positions, velocities)

    @property
    def duration(self) -> float:
        """Seconds from first to last position."""
        return float(self.times[-1])

    def at(self, times: Array) -> Array:
        """Positions (m, dof) at ``times`` (m,), held before the start and after the end."""
        return self.states_at(times)[0]

    def states_at(self, times: Array) -> tuple[Array, Array]:
        """Positions and velocities (m, dof) at ``times`` (m,); at rest before and after."""
        times = np.asarray(times, dtype=np.float64)
        if self.times.size == 1:
            positions = np.repeat(self.positions, times.size, axis=0)
            return positions, np.zeros_like(positions)
        row = np.searchsorted(self.times, times, side="right") - 1
        row = np.clip(row, 0, self.times.size - 2)
        length = (self.times[1:] - self.times[:-1])[row]
        share = np.clip((times - self.times[row]) / length, 0.0, 1.0)[:, None]
        length = length[:, None]
        begin, end = self.positions[row], self.positions[row + 1]
        leaving, arriving = length * self.velocities[row], length * self.velocities[row + 1]
        way = end - begin
        # Powers of the share: leaving, then what bends it so that it arrives.
        square, cube = 3.0 * way - 2.0 * leaving - arriving, leaving + arriving - 2.0 * way
        positions = begin + share * (leaving + share * (square + share * cube))
        velocities = (leaving + share * (2.0 * square + 3.0 * share * cube)) / length
        outside = (times < 0.0) | (times > self.times[-1])
        velocities[outside] = 0.0
        return positions, velocities

    def part(self, first: int, last: int) -> Trajectory:
        """Rows ``first`` to ``last``, both included, as a trajectory of its own."""
        rows = slice(first, last + 1)
        times = self.times[rows] - self.times[first]
        return Trajectory(times, self.positions[rows], self.velocities[rows])


class SegmentKind(StrEnum):
    """What a segment is for."""

    TRANSIT = "transit"
    GRIPPER = "gripper"
    SWEEP = "sweep"
    RETRACT = "retract"
    REACH = "reach"
    LIFT = "lift"
    CARRY = "carry"


@dataclass(frozen=True, eq=False)
class MotionSegment:
    """One stretch of a motion.

    ``opening``: gap between the fingers (m) at the end of the segment, reached linearly in time;
    what is held, or closed on, fills it, and the fingers press with the gripper's force. ``held``:
    object attached to the tool during the segment; it is attached where it is when the segment
    starts. ``contact_free``: nothing but what is in the hand may touch the arm. ``settle``: the
    longest time (s) to wait afterwards until every object rests. ``closes_on``: object the fingers
    close on, or let go of, during the segment: they may touch it meanwhile.
    """

    kind: SegmentKind
    trajectory: Trajectory
    opening: float
    held: str | None = None
    contact_free: bool = False
    settle: float = 0.0
    closes_on: str | None = None


@dataclass(frozen=True, eq=False)
class Motion:
    """Segments executed one after the other, the gripper starting at ``opening`` (m)."""

    segments: tuple[MotionSegment, ...]
    opening: float

    def __post_init__(self) -> None:
        for before, after in zip(self.segments, self.segments[1:], strict=False):
            gap = np.abs(before.trajectory.positions[-1] - after.trajectory.positions[0]).max()
            if gap > 1e-6:
                raise ValueError(
                    f"motion: {after.kind} starts {gap:.2e} rad away from the end of {before.kind}"
                )

    @property
    def start(self) -> Array:
        """First joint positions (dof,)."""
        return self.segments[0].trajectory.positions[0]

    @property
    def end(self) -> Array:
        """Last joint positions (dof,)."""
        return self.segments[-1].trajectory.positions[-1]

    @property
    def duration(self) -> float:
        """Seconds of all trajectories together, without settling."""
        return sum(segment.trajectory.duration for segment in self.segments)

    def after_transit(self) -> Motion:
        """The motion without its leading contact-free transits, which cannot move anything.

        A motion that is nothing but such transits stays whole.
        """
        first = next((i for i, s in enumerate(self.segments) if _may_move(s)), 0)
        opening = self.segments[first - 1].opening if first else self.opening
        return Motion(self.segments[first:], opening)

    def parts(self) -> MotionParts:
        """From where the arm may first touch something to where it may do so last, and the rest.

        What comes before and after is contact-free; of a retrieval that leaves how the target is
        taken and lifted. A motion in which nothing is touched is all in the middle.
        """
        rest = self.after_transit()
        begin = len(self.segments) - len(rest.segments)
        ends = [
            number
            for number, segment in enumerate(rest.segments, start=1)
            if not segment.contact_free
            or segment.closes_on is not None
            or segment.kind is SegmentKind.LIFT
        ]
        end = ends[-1] if ends else len(rest.segments)
        touching = Motion(rest.segments[:end], rest.opening)
        return MotionParts(self.segments[:begin], touching, rest.segments[end:])


class MotionParts(NamedTuple):
    """A motion in three parts: only in the middle something may be touched."""

    before: tuple[MotionSegment, ...]
    touching: Motion
    after: tuple[MotionSegment, ...]


def _may_move(segment: MotionSegment) -> bool:
    """Whether a segment may move an object."""
    handles = segment.held is not None or segment.closes_on is not None
    return handles or not segment.contact_free
