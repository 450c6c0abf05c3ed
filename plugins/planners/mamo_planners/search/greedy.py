"""M4M (thesis, Algorithm 4): commit to every valid push, solve the MAPF problem again."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from mamo_core.interfaces.action_generator import ActionRequest
from mamo_core.interfaces.search_strategy import ProgressCallback, SearchStrategy
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array
from mamo_core.types.mapf import GoalPenalty, MAPFBudget
from mamo_core.types.region import SweptRegion
from mamo_core.types.solution import Budget, Plan, Solution, SolutionStatus, Statistics
from mamo_planners.diagnosis import diagnose
from mamo_planners.search.abstraction import occupied
from mamo_planners.search.judging import Accept
from mamo_planners.search.options import GreedyOptions
from mamo_planners.search.run import Paths, SearchParts, SearchRun

_FORBIDDEN_RADIUS = 0.03


class GreedySearch(SearchStrategy):
    """Attempts from the initial scene until one ends in a verified plan."""

    def __init__(self, parts: SearchParts, options: GreedyOptions) -> None:
        self._parts, self._options = parts, options

    def solve(
        self, budget: Budget, rng: np.random.Generator, progress: ProgressCallback
    ) -> Solution:
        options = self._options
        run = SearchRun(
            self._parts,
            budget,
            rng,
            progress,
            options.grasp_tries,
            self._mapf_budget,
            options.goal_margin,
        )
        hopeless = 0
        for number in range(options.attempts):
            progress(f"attempt {number + 1}")
            run.statistics.counts["attempts"] += 1
            attempt = _Attempt(run, options)
            plan = attempt.solve()
            if plan is not None:
                return Solution(SolutionStatus.SOLVED, plan, run.statistics)
            hopeless += attempt.hopeless
            if hopeless >= options.hopeless_attempts:
                return run.no_retrieval()
            if budget.exhausted:
                break
        return run.no_plan()

    def diagnose(self, solution: Solution) -> Statistics:
        return diagnose(self._parts, solution, self._mapf_budget, self._options.goal_margin)

    @property
    def _mapf_budget(self) -> MAPFBudget:
        return MAPFBudget(self._options.mapf_nodes, self._options.mapf_expansions)


class _Attempt:
    """One greedy run from the initial scene under one NGR."""

    def __init__(self, run: SearchRun, options: GreedyOptions) -> None:
        self._run, self._options = run, options
        self._stand = run.execution.start
        self._done: list[RearrangementAction] = []
        self._paths: Paths = {}
        self._mapf_calls = 0
        self.hopeless = False
        """Whether there is no retrieval even without the movables."""

    def solve(self) -> Plan | None:
        """A verified plan, or None when nothing more can be done here."""
        plan = self._retrieve(None)
        if plan is not None:
            return plan
        region = self._run.region(self._options.regions)
        if region is None:
            self.hopeless = not self._exhausted
            return None
        while not self._exhausted:
            plan = self._retrieve(region) if self._done else None
            if plan is not None:
                return plan
            if len(self._done) >= self._options.max_actions or not self._rearrange(region):
                return None
        return None

    @property
    def _exhausted(self) -> bool:
        return self._run.budget.exhausted

    def _retrieve(self, region: SweptRegion | None) -> Plan | None:
        return self._run.retrieve(self._stand, tuple(self._done), region)

    def _rearrange(self, region: SweptRegion) -> bool:
        """Find and commit to one valid action; False if none was found."""
        penalties: dict[str, list[GoalPenalty]] = defaultdict(list)
        for _ in range(self._options.rounds):
            if self._exhausted:
                return False
            if not self._paths and not self._solve_mapf(region, penalties):
                break
            for name in self._run.rng.permutation(sorted(self._paths)):
                if self._try_object(region, str(name), self._paths[str(name)]):
                    if self._options.iterate:
                        self._paths = {}
                    else:
                        del self._paths[str(name)]
                    return True
                if self._exhausted:
                    return False
            for name, path in self._paths.items():
                penalties[name].append(GoalPenalty(path[-1], _FORBIDDEN_RADIUS, float("inf")))
            self._paths = {}
        return self._try_agnostic(region)

    def _solve_mapf(self, region: SweptRegion, penalties: dict[str, list[GoalPenalty]]) -> bool:
        if self._mapf_calls and not self._options.iterate:
            return False
        self._mapf_calls += 1
        self._paths = self._run.paths(self._stand.state, region, penalties)
        self._run.progress(f"{len(self._done)} actions, {len(self._paths)} objects in the way")
        return bool(self._paths)

    def _try_object(self, region: SweptRegion, name: str, path: Array) -> bool:
        request = ActionRequest(name, path, region)
        return any(self._try_action(kind, request, None) for kind, _ in self._run.parts.actions)

    def _try_agnostic(self, region: SweptRegion) -> bool:
        """Pushes in random directions that leave less of the NGR occupied."""
        run, state = self._run, self._stand.state
        inside = occupied(run.parts.problem, state, region)
        for _ in range(self._options.agnostic if inside else 0):
            if self._exhausted:
                return False
            name = inside[int(run.rng.integers(len(inside)))]
            request = ActionRequest(name, None, region)
            accept = run.lessens(region, state)
            if any(self._try_action(kind, request, accept) for kind, _ in run.parts.actions):
                return True
        return False

    def _try_action(self, kind: str, request: ActionRequest, accept: Accept | None) -> bool:
        found = self._run.realise(self._stand, kind, request, accept)
        if found is None:
            return False
        action, self._stand = found
        self._done.append(action)
        return True
