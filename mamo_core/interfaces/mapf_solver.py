"""Which objects move where, without physics."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from mamo_core.types.mapf import MAPFBudget, MAPFProblem, MAPFSolution


class MAPFSolver(ABC):
    """Multi-agent pathfinding with true footprints and goal regions."""

    @abstractmethod
    def solve(
        self, problem: MAPFProblem, budget: MAPFBudget, rng: np.random.Generator
    ) -> MAPFSolution:
        """Conflict-free paths out of the region, or why there are none."""
