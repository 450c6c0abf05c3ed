"""Collects violations over a rollout: each once, at its onset, in time order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mamo_core.constraints.kernels import within
from mamo_core.constraints.limits import LimitedConstraint, Limits, tightest
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.types.geometry import Array, BoolArray
from mamo_core.types.rollout import StepObservation, Violation


class ConstraintMonitor:
    """Shows every step to every constraint; a violation is kept when it was not there before.

    Constraints with limits are compiled into one glance: they are asked about the steps that are
    not within the limits of all of them.
    """

    def __init__(self, constraints: Sequence[InteractionConstraint]) -> None:
        self._constraints = tuple(constraints)
        self._others = tuple(c for c in constraints if not isinstance(c, LimitedConstraint))
        limits = [c.limits for c in constraints if isinstance(c, LimitedConstraint)]
        self._limited = bool(limits)
        if limits:
            tight = tightest(limits)
            self._bounds, self._forbidden = _laid_out(tight)
            self._deepest = tight.deepest
        self._active: frozenset[tuple[str, str, str | None]] = frozenset()
        self.violations: list[Violation] = []

    def limits(self, held: int) -> tuple[Array, BoolArray, float, int] | None:
        """What ``within`` takes: no step within these has to be seen.

        None if somebody wants to see all.
        """
        if self._others or not self._limited:
            return None
        return self._bounds, self._forbidden[1 + held], self._deepest, _entity(held)

    def passed(self) -> None:
        """At least one step within the limits was not shown: nothing is broken any more."""
        self._active = frozenset()

    def see(self, step: StepObservation) -> bool:
        """Take one step in; True if anything new is broken."""
        harmless = not self._limited or within(
            *(step.positions, step.z_axes, step.velocities, step.contacts, step.depths),
            *(self._bounds, self._forbidden[1 + step.held], self._deepest, _entity(step.held)),
        )
        asked = self._others if harmless else self._constraints
        if not asked and not self._active:
            return False
        found = [v for c in asked for v in c.violations(step)]
        if not found and not self._active:
            return False
        fresh = [v for v in found if (v.constraint, v.subject, v.other) not in self._active]
        self._active = frozenset((v.constraint, v.subject, v.other) for v in found)
        self.violations.extend(fresh)
        return bool(fresh)


def _entity(held: int) -> int:
    """Number of the object in the hand among all entities, or -1."""
    return 1 + held if held >= 0 else -1


def _laid_out(limits: Limits) -> tuple[Array, list[BoolArray]]:
    """Limits as the kernel wants them: bounds of objects (n, 6), and forbidden pairs."""
    for_all = np.broadcast_to([limits.cosine, limits.square], (len(limits.lowest), 2))
    return np.column_stack([limits.lowest, limits.axes, for_all]), list(limits.forbidden)
