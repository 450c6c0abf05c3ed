"""What a planner returns: a plan that can be replayed, and where the time went."""

from __future__ import annotations

import time
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from mamo_core.types.action import RearrangementAction
from mamo_core.types.motion import Motion
from mamo_core.types.region import SweptRegion


class SolutionStatus(StrEnum):
    """How a search ended."""

    SOLVED = "solved"
    NO_PLAN_PROVED = "no_plan_proved"
    BUDGET_EXHAUSTED = "budget_exhausted"
    VERIFICATION_FAILED = "verification_failed"


@dataclass(frozen=True, eq=False)
class Plan:
    """Rearrangements in order, then what does the task; ``region`` is the NGR that was cleared.

    ``retrieval``: the motion that ends the plan; it only reaches where the task is to reach.
    """

    actions: tuple[RearrangementAction, ...]
    retrieval: Motion
    region: SweptRegion | None = None

    @property
    def motions(self) -> tuple[Motion, ...]:
        """Everything the arm executes, in order."""
        return (*(action.motion for action in self.actions), self.retrieval)


@dataclass
class Statistics:
    """Filled while planning: CPU ``seconds`` by part, ``counts`` of work, failure ``causes``.

    ``outside_cpu``: how many of the seconds were spent in other processes.

    The keys of ``causes`` read ``subject/action/cause``, for example ``o7/push/no_ik``; under the
    same keys ``involved`` counts who took part, as tuples of names, where that is known. ``worked``
    counts what did not fail, by ``subject/action``. Plan files hold neither of these two.
    """

    seconds: Counter[str] = field(default_factory=Counter)
    counts: Counter[str] = field(default_factory=Counter)
    causes: Counter[str] = field(default_factory=Counter)
    outside_cpu: float = 0.0
    involved: defaultdict[str, Counter[tuple[str, ...]]] = field(
        default_factory=lambda: defaultdict(Counter)
    )
    worked: Counter[str] = field(default_factory=Counter)

    @contextmanager
    def timed(self, part: str) -> Iterator[None]:
        """Add the CPU seconds of the block to ``part``."""
        start = time.process_time()
        try:
            yield
        finally:
            self._add(part, time.process_time() - start)

    def charge(self, part: str, seconds: float) -> None:
        """Add CPU seconds that another process spent for ``part``."""
        self.outside_cpu += seconds
        self._add(part, seconds)

    def _add(self, part: str, seconds: float) -> None:
        self.seconds[part] += seconds  # type: ignore[assignment]

    def failed(
        self,
        subject: str,
        action: str,
        cause: str,
        times: int = 1,
        involved: tuple[str, ...] = (),
    ) -> None:
        """Count a failure by its cause; ``involved``: who took part in it, by name."""
        if not times:
            return
        key = f"{subject}/{action}/{cause}"
        self.causes[key] += times
        if involved:
            self.involved[key][involved] += times

    def succeeded(self, subject: str, action: str) -> None:
        """Count something that was done with a subject and did not fail."""
        self.worked[f"{subject}/{action}"] += 1


@dataclass(frozen=True, eq=False)
class Solution:
    """The outcome of planning; ``plan`` is there only if it was verified.

    ``reason``: in words, why there is no plan.
    """

    status: SolutionStatus
    plan: Plan | None
    statistics: Statistics
    reason: str = ""
    info: Mapping[str, Any] = field(default_factory=dict)


@dataclass
class Budget:
    """The outermost limit: CPU ``seconds`` from ``started`` (process time), or infinite."""

    seconds: float = float("inf")
    started: float = field(default_factory=time.process_time)
    elsewhere: float = 0.0

    def charge(self, seconds: float) -> None:
        """Count CPU seconds that other processes spent for this search."""
        self.elsewhere += seconds

    @property
    def exhausted(self) -> bool:
        """Whether the time is up."""
        return time.process_time() - self.started + self.elsewhere >= self.seconds
