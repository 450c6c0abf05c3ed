"""Engines that follow the first one: they must agree that an action, or the retrieval, is valid."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Statistics
from mamo_planners.search.judging import Accept, Judge
from mamo_planners.search.rollouts import KEEP, Rollouts
from mamo_planners.search.stand import Line

ContactFree = Callable[[Motion, Sequence[SceneState]], bool]
"""Whether a motion's contact-free segments touch nothing, given the state each starts from."""
Clear = Callable[[Motion, SceneState], bool]
"""Whether a retrieval surely touches nothing but the target, from a state at rest."""

_REFUSAL = "not_valid_in_samples"
_FARTHER = 0.06
"""The arm goes on so long (s) after it is clear in the first engine: samples differ a little."""


class Samples:
    """Lines that execute each action from its sweep on, from rest: sampled masses and frictions.

    ``needed`` of them, over the whole plan, must agree. Those that refused most often so far are
    asked first, as many at a time as it takes at least to refuse. What need not be simulated, the
    way to a sweep and that of the retrieval, must be free in all of them that have held so far.
    """

    def __init__(
        self,
        collision: CollisionChecker,
        contact_free: ContactFree,
        clear: Clear,
        rollouts: Rollouts,
        judge: Judge,
        statistics: Statistics,
        needed: int,
    ) -> None:
        self._collision, self._contact_free, self._clear = collision, contact_free, clear
        self._rollouts, self._judge, self._stats = rollouts, judge, statistics
        self._needed = needed
        self._refusals: Counter[str] = Counter()

    def follow(
        self,
        lines: Sequence[Line],
        action: RearrangementAction,
        accept: Accept | None,
        expected: SceneState,
    ) -> tuple[Line, ...] | None:
        """The lines after the action; None if too few hold. ``expected``: about where it leads."""
        if not lines:
            return ()
        motion = action.motion
        if not all(self._transits_free(motion, line.state) for line in lines):
            self._stats.failed(action.object_name, action.kind, _REFUSAL)
            return None
        short, rest = self._shortened(motion.after_transit(), expected)

        def followed(line: Line, result: RolloutResult) -> Line | None:
            if rest is not None and result.valid and not self._free_after(result, motion, rest):
                result = self._rollouts.one(line, motion, None)
            good = self._judge.good(result, action, accept)
            return line.after(result, motion) if good and self._free(line, result, motion) else None

        return self._asked(lines, short, followed, (action.object_name, action.kind))

    def hold(self, lines: Sequence[Line], retrieval: Motion) -> bool:
        """Whether nothing but the target is near the way of a retrieval, in all of the lines.

        It need not be executed there: from rest, masses and frictions only matter to what is
        touched, and where something is, it may be touched with others.
        """
        clear = all(self._clear(retrieval, line.state) for line in lines)
        if not clear:
            self._stats.failed("arm", "retrieval", _REFUSAL)
        return clear

    def _asked(
        self,
        lines: Sequence[Line],
        motion: Motion,
        after: Callable[[Line, RolloutResult], Line | None],
        who: tuple[str, str],
    ) -> tuple[Line, ...] | None:
        """What ``after`` says of each line, where it says anything; None if it is too little."""
        pending = sorted(lines, key=lambda line: -self._refusals[line.engine.name])
        spare = len(lines) - self._needed
        found: dict[str, Line] = {}
        while pending and spare >= 0:
            some, pending = pending[: spare + 1], pending[spare + 1 :]
            results = self._rollouts.side_by_side(some, motion)
            for line, result in zip(some, results, strict=True):
                next_line = after(line, result)
                if next_line is not None:
                    found[line.engine.name] = next_line
                    continue
                self._refusals[line.engine.name] += 1
                spare -= 1
        if spare < 0:
            self._stats.failed(*who, _REFUSAL)
            return None
        return tuple(found[n] for n in (line.engine.name for line in lines) if n in found)

    def _shortened(self, motion: Motion, expected: SceneState) -> tuple[Motion, Array | None]:
        """The motion up to where the arm is clear of everything, and its configurations after."""
        last = motion.segments[-1]
        way, times = last.trajectory.positions, last.trajectory.times
        if last.kind is not SegmentKind.RETRACT or last.held is not None:
            return motion, None
        world = self._collision.world(expected.object_poses, opening=last.opening)
        blocked = np.flatnonzero(~world.free(way))
        end = int(np.searchsorted(times, (times[blocked[-1]] if len(blocked) else 0.0) + _FARTHER))
        if end >= len(way) - 1:
            return motion, None
        cut = replace(last, trajectory=last.trajectory.part(0, end))
        segments = (*motion.segments[:-1], cut)
        return Motion(segments, motion.opening), way[end:]

    def _free_after(self, result: RolloutResult, motion: Motion, rest: Array) -> bool:
        """Whether the arm touches nothing on the rest of its way."""
        opening = motion.segments[-1].opening
        world = self._collision.world(result.final_state.object_poses, opening=opening)
        return bool(world.free(rest).all())

    def _transits_free(self, motion: Motion, state: SceneState) -> bool:
        """Whether a way that was planned for the first engine's poses is free for these, too.

        It is planned with the checker's distance to everything, and keeps it here.
        """
        transits = motion.segments[: -len(motion.after_transit().segments)]
        return all(self._transit_free(transit, state) for transit in transits)

    def _transit_free(self, transit: MotionSegment, state: SceneState) -> bool:
        world = self._collision.world(state.object_poses, opening=transit.opening)
        return bool(world.free(transit.trajectory.positions).all())

    def _free(self, line: Line, result: RolloutResult, motion: Motion) -> bool:
        """Whether contact-free segments touch nothing."""
        states = result.segment_states
        before = len(motion.segments) - len(states)
        return self._contact_free(motion, (*([line.state] * before), *states))


class Witnesses:
    """Engines that execute everything continuously; all of them must agree."""

    def __init__(
        self,
        contact_free: ContactFree,
        rollouts: Rollouts,
        judge: Judge,
        statistics: Statistics,
    ) -> None:
        self._contact_free = contact_free
        self._rollouts, self._judge, self._stats = rollouts, judge, statistics

    def follow(
        self, lines: Iterable[Line], action: RearrangementAction, accept: Accept | None
    ) -> tuple[Line, ...] | None:
        """The lines after the action; None if it is not valid in one of them."""
        followed: list[Line] = []
        for line in lines:
            result = self._rollouts.one(line, action.motion, KEEP)
            good = self._judge.good(result, action, accept)
            if not good or not self._contact_free(action.motion, result.segment_states):
                self._refused(line, action.object_name, action.kind)
                return None
            followed.append(line.after(result, action.motion))
        return tuple(followed)

    def hold(self, lines: Iterable[Line], retrieval: Motion) -> bool:
        """Whether the retrieval is valid in all lines."""
        for line in lines:
            result = self._rollouts.one(line, retrieval, None)
            good = self._judge.retrieved(result)
            if not good or not self._contact_free(retrieval, result.segment_states):
                self._refused(line, "arm", "retrieval")
                return False
        return True

    def _refused(self, line: Line, subject: str, kind: str) -> None:
        self._stats.failed(subject, kind, f"not_valid_in_{line.engine.name}")


class Followers(NamedTuple):
    """Lines by how they follow: samples and neighbours start each action from rest."""

    samples: tuple[Line, ...]
    neighbours: tuple[Line, ...]
    continuous: tuple[Line, ...]


def split(lines: Sequence[Line]) -> Followers:
    """The lines by how they follow."""
    return Followers(
        tuple(o for o in lines if not (o.engine.continuous or o.engine.nearby)),
        tuple(o for o in lines if o.engine.nearby),
        tuple(o for o in lines if o.engine.continuous),
    )
