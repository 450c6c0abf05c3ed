"""Time estimated from counted work, so that what depends on it repeats on a busy machine."""

from __future__ import annotations

from dataclasses import dataclass

EXPANSION_SECONDS = 2.5e-4
"""CPU time of expanding a state of the lattice, of the order measured on a 2020s core."""

STEP_SECONDS = 4e-5
"""CPU time of a simulated step, likewise."""


@dataclass
class Work:
    """Estimated CPU ``seconds`` since the start."""

    seconds: float = 0.0

    def expanded(self) -> float:
        """One state; the seconds it counts for."""
        return self._add(EXPANSION_SECONDS)

    def simulated(self, steps: int) -> float:
        """So many steps of an engine; the seconds they count for."""
        return self._add(steps * STEP_SECONDS)

    def _add(self, seconds: float) -> float:
        self.seconds += seconds
        return seconds
