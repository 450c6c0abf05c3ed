"""Interaction constraints: one definition, seen by every step of every engine."""

from __future__ import annotations

from abc import ABC, abstractmethod

from mamo_core.types.rollout import StepObservation, Violation


class InteractionConstraint(ABC):
    """What may not happen to objects; built for one problem and free of state."""

    @abstractmethod
    def violations(self, step: StepObservation) -> list[Violation]:
        """Everything that is broken at this step (an empty list almost always: be quick)."""
