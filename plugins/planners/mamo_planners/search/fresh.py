"""A second opinion on a plan, from samples that the search has not been adapted to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionChecker
from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.types.scene import Scene, SceneState
from mamo_core.types.solution import Plan, Statistics
from mamo_planners.search.followers import Clear, ContactFree, Samples
from mamo_planners.search.judging import Judge
from mamo_planners.search.options import Uncertainty
from mamo_planners.search.rollouts import Rollouts
from mamo_planners.search.stand import Engine, Line
from mamo_planners.search.uncertainty import needed, sampled


@dataclass(frozen=True, eq=False)
class FreshEngines:
    """``draw``: each time as many engines, with masses and frictions that nobody has seen.

    ``tolerated``: how many of those of two draws may fail.
    """

    draw: Callable[[], Sequence[Engine]]
    tolerated: int


def fresh_engines(
    scene: Scene, uncertainty: Uncertainty, rng: np.random.Generator, model: TransitionModel
) -> FreshEngines | None:
    """None if the options ask for none."""
    count = uncertainty.fresh
    if count == 0:
        return None
    # The search's own generator must not feel how often they are drawn.
    own = rng.spawn(1)[0]

    def draw() -> list[Engine]:
        values = sampled(scene, uncertainty, own, count)
        return [Engine(f"fresh_{n}", model, v, continuous=False) for n, v in enumerate(values)]

    return FreshEngines(draw, 2 * count - needed(uncertainty.fresh_threshold, 2 * count))


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
        """Whether all of some execute the whole plan, or enough of twice as many.

        ``expected``: about where each action leads. Most plans are clear cases, for which half of
        the samples will do (double sampling).
        """
        tolerated = self._engines.tolerated
        for _ in range(2):
            engines = self._engines.draw()
            left = self._left(engines, tolerated, start, plan, expected)
            if left is None or len(left) == len(engines):
                return left is not None
            tolerated -= len(engines) - len(left)
        return True

    def _left(
        self,
        engines: Sequence[Engine],
        tolerated: int,
        start: SceneState,
        plan: Plan,
        expected: Sequence[SceneState],
    ) -> tuple[Line, ...] | None:
        """Those that execute the plan; None if more fail than are tolerated."""
        enough = len(engines) - tolerated
        samples = Samples(*self._parts, enough, "not_valid_in_fresh_samples")
        lines = tuple(Line(engine, start) for engine in engines)
        for action, state in zip(plan.actions, expected, strict=True):
            followed = samples.follow(lines, action, None, state)
            if followed is None:
                return None
            lines = followed
        return samples.holding(lines, plan.retrieval)
