"""Worlds close to the problem's: what holds in one of them alone was found by luck."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from mamo_core.types.action import RearrangementAction
from mamo_core.types.motion import Motion, MotionSegment
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Statistics
from mamo_planners.search.judging import Judge
from mamo_planners.search.rollouts import Rollouts
from mamo_planners.search.stand import Line

Passes = Callable[[Sequence[MotionSegment], SceneState, float], bool]


class Neighbours:
    """Lines that execute each motion from rest, as the verifier does: where something is touched.

    ``passes``: whether segments, from a state and an opening (m), touch nothing. All must hold.
    Those that refused most often so far are asked first: one refusal is enough.
    """

    def __init__(
        self, passes: Passes, rollouts: Rollouts, judge: Judge, statistics: Statistics
    ) -> None:
        self._passes = passes
        self._rollouts, self._judge, self._stats = rollouts, judge, statistics
        self._refusals: Counter[str] = Counter()

    def follow(self, lines: Sequence[Line], action: RearrangementAction) -> tuple[Line, ...] | None:
        """The lines after the action; None if it breaks something in one of them."""
        return self._all(lines, action.motion, action.object_name, action.kind)

    def hold(self, lines: Sequence[Line], retrieval: Motion) -> bool:
        """Whether the retrieval holds in all lines."""
        return self._all(lines, retrieval, "arm", "retrieval") is not None

    def _all(
        self, lines: Sequence[Line], motion: Motion, subject: str, kind: str
    ) -> tuple[Line, ...] | None:
        found: dict[str, Line] = {}
        for line in sorted(lines, key=lambda line: -self._refusals[line.engine.name]):
            result = self._executed(line, motion)
            if not self._judge.holds(result, subject, kind):
                self._refusals[line.engine.name] += 1
                return None
            found[line.engine.name] = line.after(result, motion)
        return tuple(found[line.engine.name] for line in lines)

    def _executed(self, line: Line, motion: Motion) -> RolloutResult:
        before, touching, after = motion.parts()
        if self._passes(before, line.state, motion.opening):
            result = self._rollouts.from_rest(line, touching)
            opening = touching.segments[-1].opening
            if not result.valid or self._passes(after, result.final_state, opening):
                return result
        return self._rollouts.from_rest(line, motion)
