"""Primitives that failed near their goal, to be varied: a small change may make them hold."""

from __future__ import annotations

import heapq

import numpy as np

from mamo_planners.reaching.primitive import Primitive

_SIZE = 8
_CLOSE = 0.3
"""Primitives that came closer than this (rad) are about equally likely."""


class Promising:
    """The few failed primitives that came closest to their ends."""

    def __init__(self) -> None:
        self._best: list[tuple[float, int, Primitive]] = []
        self._seen = 0

    def failed(self, primitive: Primitive, left: float) -> None:
        """``left``: length of the primitive's path beyond where it failed, rad.

        Not a share of it: the longest detour would seem to have held best.
        """
        # Of two that came equally close the later one stays: it may lead away from a dead end.
        heapq.heappush(self._best, (-left, self._seen, primitive))
        self._seen += 1
        if len(self._best) > _SIZE:
            heapq.heappop(self._best)

    def drawn(self, rng: np.random.Generator) -> Primitive | None:
        """One of them, the closer it came the likelier; None if nothing has failed."""
        if not self._best:
            return None
        weights = 1.0 / (_CLOSE + np.array([-key for key, _, _ in self._best]))
        chosen = int(rng.choice(len(weights), p=weights / weights.sum()))
        return self._best[chosen][2]
