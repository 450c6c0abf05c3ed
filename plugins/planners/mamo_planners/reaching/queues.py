"""Multi-heuristic A* (Aine et al., 2016): one open list for each heuristic.

The list that the search has spent the least work on is next, so that expensive evaluations from one
list do not starve the others (thesis 3.4.1).
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence


class Queues:
    """Open states by number. ``w1`` inflates heuristics; the first list is the anchor.

    A list whose best key exceeds ``w2`` times the anchor's has to let the anchor go first.
    """

    def __init__(self, count: int, w1: float, w2: float) -> None:
        self._heaps: list[list[tuple[float, int, int]]] = [[] for _ in range(count)]
        self._keys: list[dict[int, float]] = [{} for _ in range(count)]
        self._spent = [0.0] * count
        self._w1, self._w2 = w1, w2
        self._pushed = 0

    def push(self, state: int, cost: float, heuristics: Sequence[float]) -> None:
        """Put a state into all lists, or move it there."""
        for queue, h in enumerate(heuristics):
            self.push_into(queue, state, cost, h)

    def push_into(self, queue: int, state: int, cost: float, heuristic: float) -> None:
        """Put a state into one list, or move it there."""
        key = cost + self._w1 * heuristic
        self._keys[queue][state] = key
        heapq.heappush(self._heaps[queue], (key, self._pushed, state))
        self._pushed += 1

    def pop(self) -> tuple[int, int] | None:
        """The next state and the list it came from; it leaves all lists. None if all are empty."""
        best = [self._best(queue) for queue in range(len(self._heaps))]
        filled = [queue for queue, key in enumerate(best) if key is not None]
        if not filled:
            return None
        queue = min(filled, key=lambda q: (self._spent[q], q))
        anchor, own = best[0], best[queue]
        if anchor is not None and own is not None and own > self._w2 * anchor:
            queue = 0
        state = self._heaps[queue][0][2]
        for keys in self._keys:
            keys.pop(state, None)
        return state, queue

    def spend(self, queue: int, work: float) -> None:
        """Charge work to a list."""
        self._spent[queue] += work

    def _best(self, queue: int) -> float | None:
        heap, keys = self._heaps[queue], self._keys[queue]
        while heap and keys.get(heap[0][2]) != heap[0][0]:
            heapq.heappop(heap)
        return heap[0][0] if heap else None
