"""Collects violations over a rollout: each once, at its onset, in time order."""

from __future__ import annotations

from collections.abc import Sequence

from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.types.rollout import StepObservation, Violation


class ConstraintMonitor:
    """Shows every step to every constraint; a violation is kept when it was not there before."""

    def __init__(self, constraints: Sequence[InteractionConstraint]) -> None:
        self._constraints = tuple(constraints)
        self._active: frozenset[tuple[str, str, str | None]] = frozenset()
        self.violations: list[Violation] = []

    def see(self, step: StepObservation) -> bool:
        """Take one step in; True if anything new is broken."""
        found = [v for c in self._constraints for v in c.violations(step)]
        if not found and not self._active:
            return False
        fresh = [v for v in found if (v.constraint, v.subject, v.other) not in self._active]
        self._active = frozenset((v.constraint, v.subject, v.other) for v in found)
        self.violations.extend(fresh)
        return bool(fresh)
