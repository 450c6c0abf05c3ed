"""Worlds close to the problem's: what holds in one of them alone was found by luck."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from mamo_core.types.action import RearrangementAction
from mamo_core.types.motion import Motion
from mamo_core.types.solution import Statistics
from mamo_planners.search.judging import Judge
from mamo_planners.search.rollouts import Rollouts
from mamo_planners.search.stand import Line


class Neighbours:
    """Lines that execute each motion from its first touch on, from rest, as the verifier does.

    All must hold. Those that refused most often so far are asked first: one refusal is enough.
    """

    def __init__(self, rollouts: Rollouts, judge: Judge, statistics: Statistics) -> None:
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
            result = self._rollouts.one(line, motion, None)
            if not self._judge.holds(result, subject, kind):
                self._refusals[line.engine.name] += 1
                return None
            found[line.engine.name] = line.after(result, motion)
        return tuple(found[line.engine.name] for line in lines)
