"""Soft duplicates: what is like something that failed is put off once (thesis 3.3.6)."""

from __future__ import annotations

import numpy as np

from mamo_core.types.geometry import Array

_INFLATION = 10.0


class SoftDuplicates:
    """Configurations where simulations failed; ``beta``: how close, rad (None: nothing is)."""

    def __init__(self, beta: float | None) -> None:
        self._beta = beta
        self._failed: list[Array] = []

    def failed(self, q: Array) -> None:
        """What began at ``q`` (dof,) is not valid."""
        self._failed.append(q)

    def near(self, q: Array) -> bool:
        """Whether something failed that began within beta of ``q`` (dof,)."""
        if self._beta is None or not self._failed:
            return False
        return bool((np.linalg.norm(np.array(self._failed) - q, axis=1) < self._beta).any())


def inflated(heuristic: float) -> float:
    """The heuristic of what is put off, also where a subgoal begins, to which it is 0."""
    return _INFLATION * max(heuristic, 1.0)
