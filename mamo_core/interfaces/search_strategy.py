"""The planner's outer loop."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np

from mamo_core.types.solution import Budget, Solution, Statistics

ProgressCallback = Callable[[str], None]
"""Told, in words, what the search is doing."""


class SearchStrategy(ABC):
    """Receives its parts when built; returns SOLVED only with a verified plan."""

    @abstractmethod
    def solve(
        self, budget: Budget, rng: np.random.Generator, progress: ProgressCallback
    ) -> Solution:
        """Search until solved, proved unsolvable or out of budget."""

    def diagnose(self, solution: Solution) -> Statistics:
        """What stands in the way, as further causes; asked only where ``solution`` has no plan.

        It looks at the problem once more, apart from the search: it draws nothing from the
        search's generator and its work is limited. By default nothing is known.
        """
        return Statistics()
