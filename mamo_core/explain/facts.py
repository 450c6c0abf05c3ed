"""What the ranking of explanations asks."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import cached_property

from mamo_core.explain.details import details_of
from mamo_core.explain.explanation import Detail
from mamo_core.explain.words import BLOCKED
from mamo_core.types.problem import Problem
from mamo_core.types.scene import ROBOT_NAME, Mobility
from mamo_core.types.solution import Solution, Statistics

RETRIEVAL, PATHS, REACH = "retrieval", "mapf", "reach"
"""What is done to no movable: taking out the target, planning without physics, reaching."""

IN_THE_WAY = "in_the_way"
"""Counted by a second look for each movable that stands where a retrieval sweeps."""

_ARM_SUBJECTS = ("arm", ROBOT_NAME, "plan")
"""Who executes: causes under these names are no object's."""

_NO_ACTIONS = {RETRIEVAL, PATHS, REACH}

_SIMULATED = {"stalled", "unmoved", "too_close", "arm_blocked_after", "no_gain"}
"""Found out by simulating, as are all interaction constraints of the problem."""


@dataclass(frozen=True, eq=False)
class Facts:
    """``counted`` by the search, and what ``found`` of a second look at the initial scene."""

    problem: Problem
    solution: Solution
    found: Statistics

    @property
    def target(self) -> str:
        """Name of the target."""
        scene = self.problem.scene
        return scene.objects[scene.target_index].name

    @cached_property
    def details(self) -> tuple[Detail, ...]:
        """Everything that is known."""
        return details_of(self.problem.scene, self.solution.statistics, self.found)

    @property
    def looked(self) -> bool:
        """Whether there was a second look."""
        return bool(self.found.causes or self.found.seconds)

    def of(self, action: str, subjects: Collection[str], *, found: bool = False) -> list[Detail]:
        """Details of one action and some subjects; ``found``: of the second look alone."""
        among = details_of(self.problem.scene, self.found) if found else self.details
        return [d for d in among if d.action == action and d.subject in subjects]

    @property
    def movables(self) -> tuple[str, ...]:
        """Names of the movables."""
        objects = self.problem.scene.objects
        return tuple(o.name for o in objects if o.mobility is Mobility.MOVABLE)

    @property
    def blockers(self) -> tuple[str, ...]:
        """Movables in the way, or where nobody looked those that something was tried with.

        First those that are in more of the ways looked at; then those that were never moved; then
        those with more failures.
        """
        ways = {d.subject: d.times for d in self.details if d.cause == IN_THE_WAY}
        tried = {d.subject for d in self.details if d.action not in _NO_ACTIONS}
        names = [n for n in self.movables if n in (ways if self.looked else tried)]
        failures = {n: sum(d.times for d in self.details if d.subject == n) for n in names}
        names.sort(key=lambda n: (-ways.get(n, 0), self.moved(n) > 0, -failures[n], n))
        return tuple(names)

    def moved(self, name: str) -> int:
        """How often an object was moved by a valid action."""
        worked = self.solution.statistics.worked
        return sum(n for key, n in worked.items() if key.startswith(f"{name}/"))

    def actions_with(self, name: str) -> tuple[str, ...]:
        """Actions that were tried with an object and failed, those that were simulated first."""
        tried = [d for d in self.details if d.subject == name]
        known = {d.action for d in tried} - _NO_ACTIONS
        simulated = {d.action for d in tried if d.cause in self._simulated}
        return tuple(sorted(known, key=lambda action: (action not in simulated, action)))

    def furthest(self, details: Iterable[Detail]) -> list[Detail]:
        """Those that were found out by simulating; all, if none was, what blocks them first.

        Candidates that fail before are replaced by others; those that got to be simulated are
        what could have been done.
        """
        chosen = list(details)
        simulated = [d for d in chosen if d.cause in self._simulated]
        return simulated or sorted(chosen, key=lambda d: d.cause != BLOCKED)

    def are_simulated(self, details: Iterable[Detail]) -> bool:
        """Whether all of them were found out by simulating."""
        return all(d.cause in self._simulated for d in details)

    @property
    def executing(self) -> list[Detail]:
        """What failed when the retrieval, or a whole plan, was executed."""
        return [d for d in self.details if d.subject in _ARM_SUBJECTS]

    @property
    def _simulated(self) -> set[str]:
        return _SIMULATED | {spec.name for spec in self.problem.constraints}
