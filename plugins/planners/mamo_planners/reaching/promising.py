"""Primitives that failed late, to be varied: what nearly held may hold with a small change."""

from __future__ import annotations

import heapq

import numpy as np

from mamo_planners.reaching.primitive import Primitive

_SIZE = 8


class Promising:
    """The few failed primitives of which the largest share held before they failed."""

    def __init__(self) -> None:
        self._best: list[tuple[float, int, Primitive]] = []
        self._seen = 0

    def failed(self, primitive: Primitive, held: float) -> None:
        """``held``: the share (0 to 1) of the primitive's duration before it failed."""
        # Of two that held equally long the later one stays: it may lead away from a dead end.
        heapq.heappush(self._best, (held, self._seen, primitive))
        self._seen += 1
        if len(self._best) > _SIZE:
            heapq.heappop(self._best)

    def drawn(self, rng: np.random.Generator) -> Primitive | None:
        """One of them, the longer it held the likelier; None if nothing has failed."""
        if not self._best:
            return None
        weights = np.array([held for held, _, _ in self._best]) + 1e-9
        chosen = int(rng.choice(len(weights), p=weights / weights.sum()))
        return self._best[chosen][2]
