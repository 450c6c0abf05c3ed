"""Recorded executions of a plan: all that pictures and replays need, whatever the engine."""

from __future__ import annotations

from dataclasses import dataclass

from mamo_core.types.geometry import Array, BoolArray, IntArray
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import Violation
from mamo_core.types.solution import Plan


@dataclass(frozen=True, eq=False)
class RecordedExecution:
    """What one engine did, in the rows of the recording's ``times`` (t,).

    ``joints`` (t, dof) rad; ``openings`` (t,) m; ``poses`` (t, n, 7) of the objects, world;
    ``contacts`` (t, e, e): what touched since the row before, ascending pairs of entity numbers.
    ``violations`` in time order, on the recording's clock; ``failures``: what the verification
    found, in words.
    """

    engine: str
    joints: Array
    openings: Array
    poses: Array
    contacts: BoolArray
    violations: tuple[Violation, ...] = ()
    failures: tuple[str, ...] = ()

    def broken_by(self, time: float) -> tuple[Violation, ...]:
        """The violations until then, s."""
        return tuple(violation for violation in self.violations if violation.time <= time)


@dataclass(frozen=True, eq=False)
class Stretch:
    """Rows ``first`` to ``last`` of a recording: a segment of the plan.

    ``motion``: its number in ``Plan.motions``; ``kind``: of the segment; ``held``: object in hand.
    """

    first: int
    last: int
    motion: int
    kind: str
    held: str | None


@dataclass(frozen=True, eq=False)
class Recording:
    """A plan as one or several engines executed it, on one time grid.

    ``times`` (t,) s, evenly spaced; ``segments`` (t,) number of the plan's segment, counted over
    all motions. Engines need different times until objects rest: one that is done with a segment
    earlier waits for the others. The grid ends where the first engine stopped.
    """

    problem: Problem
    plan: Plan
    times: Array
    segments: IntArray
    executions: tuple[RecordedExecution, ...]

    @property
    def stretches(self) -> tuple[Stretch, ...]:
        """The segments that were executed, in order."""
        parts = [
            (number, segment)
            for number, motion in enumerate(self.plan.motions)
            for segment in motion.segments
        ]
        found = []
        for place in range(int(self.segments[-1]) + 1):
            rows = (self.segments == place).nonzero()[0]
            number, segment = parts[place]
            found.append(Stretch(rows[0], rows[-1], number, str(segment.kind), segment.held))
        return tuple(found)

    def title(self, motion: int) -> str:
        """What the motion of that number is: ``push can``, or the task of the problem."""
        if motion < len(self.plan.actions):
            action = self.plan.actions[motion]
            return f"{action.kind} {action.object_name}"
        return self.problem.task.value
