"""A second opinion on a plan, from samples that the search has not been adapted to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Plan, Statistics
from mamo_planners.search.followers import Clear, ContactFree, Samples
from mamo_planners.search.judging import Judge
from mamo_planners.search.rollouts import Rollouts
from mamo_planners.search.stand import Engine, Line


@dataclass(frozen=True, eq=False)
class FreshEngines:
    """``draw``: engines with masses and frictions that nobody has seen; ``needed`` must hold."""

    draw: Callable[[], Sequence[Engine]]
    needed: int


class FreshSamples:
    """Samples that are drawn anew for every plan.

    A search tries actions until some hold in its own samples: of thousands that are tried, a few
    hold there and in hardly any others.
    """

    def __init__(
        self,
        engines: FreshEngines,
        collision: CollisionChecker,
        contact_free: ContactFree,
        clear: Clear,
        rollouts: Rollouts,
        judge: Judge,
        statistics: Statistics,
    ) -> None:
        self._engines = engines
        self._parts = collision, contact_free, clear, rollouts, judge, statistics

    def hold(self, start: SceneState, plan: Plan, expected: Sequence[SceneState]) -> bool:
        """Whether enough of them execute the whole plan.

        ``expected``: about where each action leads.
        """
        samples = Samples(*self._parts, self._engines.needed, "not_valid_in_fresh_samples")
        lines = tuple(Line(engine, start) for engine in self._engines.draw())
        for action, state in zip(plan.actions, expected, strict=True):
            followed = samples.follow(lines, action, None, state)
            if followed is None:
                return False
            lines = followed
        return samples.hold(lines, plan.retrieval)
