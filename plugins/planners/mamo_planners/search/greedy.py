"""M4M (thesis, Algorithm 4): commit to every valid push, solve the MAPF problem again."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mamo_core.interfaces.action_generator import ActionGenerator, ActionRequest
from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.interfaces.retrieval import RetrievalPlanner
from mamo_core.interfaces.search_strategy import ProgressCallback, SearchStrategy
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array
from mamo_core.types.mapf import GoalPenalty, MAPFBudget
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Budget, Plan, Solution, SolutionStatus, Statistics
from mamo_planners.options import GreedyOptions
from mamo_planners.search.abstraction import mapf_problem, occupancy, occupied
from mamo_planners.search.execution import ExecutionFactory

if TYPE_CHECKING:
    from mamo_core.verify import VerifyReport

_FORBIDDEN_RADIUS = 0.03

Paths = dict[str, Array]
Penalties = dict[str, list[GoalPenalty]]
Verifier = Callable[[Plan], "VerifyReport"]


class GreedySearch(SearchStrategy):
    """Attempts from the initial scene until one ends in a verified plan."""

    def __init__(
        self,
        problem: Problem,
        retrieval: RetrievalPlanner,
        mapf: MAPFSolver,
        actions: Sequence[ActionGenerator],
        execution: ExecutionFactory,
        verifier: Verifier,
        options: GreedyOptions,
    ) -> None:
        self._problem, self._retrieval, self._mapf = problem, retrieval, mapf
        self._actions, self._execution, self._verifier = actions, execution, verifier
        self._options = options
        self._mapf_budget = MAPFBudget(options.mapf_nodes, options.mapf_expansions)

    def solve(
        self, budget: Budget, rng: np.random.Generator, progress: ProgressCallback
    ) -> Solution:
        statistics = Statistics()
        hopeless = 0
        for number in range(self._options.attempts):
            progress(f"attempt {number + 1}")
            statistics.counts["attempts"] += 1
            attempt = _Attempt(self, budget, rng, statistics, progress)
            plan = attempt.run()
            if plan is not None:
                return Solution(SolutionStatus.SOLVED, plan, statistics)
            hopeless += attempt.hopeless
            if hopeless >= self._options.hopeless_attempts:
                return self._no_retrieval(statistics)
            if budget.exhausted:
                break
        return Solution(
            SolutionStatus.BUDGET_EXHAUSTED, None, statistics, "no plan within the budget"
        )

    def region(self, rng: np.random.Generator, statistics: Statistics) -> SweptRegion | None:
        """The NGR of the retrieval, of a few drawn, whose way is blocked the least."""
        best: tuple[tuple[int, float], SweptRegion] | None = None
        initial = self._problem.initial
        for _ in range(self._options.regions):
            with statistics.timed("retrieval"):
                found = self._retrieval.plan(initial, rng, ignore_movables=True)
                if found.motion is None:
                    for cause, times in found.causes.items():
                        statistics.failed(self._target_name, "retrieval", cause, times)
                    continue
                region = self._retrieval.swept_region(initial, found.motion)
            rank = occupancy(self._problem, initial, region)
            if best is None or rank < best[0]:
                best = (rank, region)
            if rank[0] == 0:
                break
        return best[1] if best is not None else None

    @property
    def _target_name(self) -> str:
        scene = self._problem.scene
        return scene.objects[scene.target_index].name

    def _no_retrieval(self, statistics: Statistics) -> Solution:
        prefix = f"{self._target_name}/retrieval/"
        causes = {
            key.removeprefix(prefix): times
            for key, times in statistics.causes.items()
            if key.startswith(prefix) and times
        }
        worst = max(causes, key=lambda cause: causes[cause], default="no grasp given")
        words = f"no way to retrieve {self._target_name} even without movables: {worst}"
        proved = set(causes) <= {"out_of_reach", "gripper_too_small"}
        status = SolutionStatus.NO_PLAN_PROVED if proved else SolutionStatus.BUDGET_EXHAUSTED
        return Solution(status, None, statistics, words)


class _Attempt:
    """One greedy run from the initial scene under one NGR."""

    def __init__(
        self,
        search: GreedySearch,
        budget: Budget,
        rng: np.random.Generator,
        statistics: Statistics,
        progress: ProgressCallback,
    ) -> None:
        self._s, self._budget = search, budget
        self._rng, self._stats, self._progress = rng, statistics, progress
        self._run = search._execution(statistics, budget)
        self._done: list[RearrangementAction] = []
        self._paths: Paths = {}
        self._mapf_calls = 0
        self.hopeless = False
        """Whether there is no retrieval even without the movables."""

    def run(self) -> Plan | None:
        """A verified plan, or None when nothing more can be done here."""
        plan = self._retrieve(None)
        if plan is not None:
            return plan
        region = self._s.region(self._rng, self._stats)
        if region is None:
            self.hopeless = not self._budget.exhausted
            return None
        while not self._budget.exhausted:
            plan = self._retrieve(region) if self._done else None
            if plan is not None:
                return plan
            if len(self._done) >= self._s._options.max_actions or not self._rearrange(region):
                return None
        return None

    def _retrieve(self, region: SweptRegion | None) -> Plan | None:
        """A verified plan if the target can be taken out now; failing grasps are left aside."""
        avoid: set[int] = set()
        for _ in range(self._s._options.grasp_tries):
            with self._stats.timed("retrieval"):
                self._stats.counts["retrievals"] += 1
                found = self._s._retrieval.plan(self._run.state, self._rng, avoid=avoid)
            if found.motion is None or self._budget.exhausted:
                return None
            plan = self._confirmed(found.motion, region)
            if plan is not None:
                return plan
            avoid.add(found.grasp)
        return None

    def _confirmed(self, retrieval: Motion, region: SweptRegion | None) -> Plan | None:
        motion = self._run.retrieval_from_here(retrieval, self._rng)
        if motion is None or not self._run.retrieval_holds(motion):
            return None
        plan = Plan(tuple(self._done), motion, region)
        with self._stats.timed("verification"):
            report = self._s._verifier(plan)
        self._stats.charge("verification", report.outside_cpu)
        self._budget.charge(report.outside_cpu)
        for failure in report.failures:
            self._stats.failed("plan", "verification", failure)
        return plan if report.ok else None

    def _rearrange(self, region: SweptRegion) -> bool:
        """Find and commit to one valid action; False if none was found."""
        penalties: Penalties = defaultdict(list)
        for _ in range(self._s._options.rounds):
            if self._budget.exhausted:
                return False
            if not self._paths and not self._solve_mapf(region, penalties):
                break
            for name in self._rng.permutation(sorted(self._paths)):
                if self._try_object(region, str(name), self._paths[str(name)]):
                    if self._s._options.iterate:
                        self._paths = {}
                    else:
                        del self._paths[str(name)]
                    return True
                if self._budget.exhausted:
                    return False
            for name, path in self._paths.items():
                penalties[name].append(GoalPenalty(path[-1], _FORBIDDEN_RADIUS, float("inf")))
            self._paths = {}
        return self._try_agnostic(region)

    def _solve_mapf(self, region: SweptRegion, penalties: Penalties) -> bool:
        if self._mapf_calls and not self._s._options.iterate:
            return False
        self._mapf_calls += 1
        problem = mapf_problem(
            self._s._problem, self._run.state, region, penalties, self._s._options.goal_margin
        )
        with self._stats.timed("mapf"):
            solution = self._s._mapf.solve(problem, self._s._mapf_budget, self._rng)
        self._stats.counts["mapf_calls"] += 1
        self._stats.counts[f"mapf_{solution.status}"] += 1
        for name, reason in solution.blame.items():
            self._stats.failed(name, "mapf", reason)
        self._paths = {n: p for n, p in solution.paths.items() if len(p) > 1 and _moves(p)}
        self._progress(f"{len(self._done)} actions, {len(self._paths)} objects in the way")
        return bool(self._paths)

    def _try_object(self, region: SweptRegion, name: str, path: Array) -> bool:
        request = ActionRequest(name, path, region)
        return any(self._try_actions(g, request, guided=True) for g in self._s._actions)

    def _try_agnostic(self, region: SweptRegion) -> bool:
        """Pushes in random directions that leave less of the NGR occupied."""
        inside = occupied(self._s._problem, self._run.state, region)
        for _ in range(self._s._options.agnostic if inside else 0):
            if self._budget.exhausted:
                return False
            name = inside[int(self._rng.integers(len(inside)))]
            request = ActionRequest(name, None, region)
            if any(self._try_actions(g, request, guided=False) for g in self._s._actions):
                return True
        return False

    def _try_actions(
        self, generator: ActionGenerator, request: ActionRequest, *, guided: bool
    ) -> bool:
        before = self._run.state
        for action in generator.propose(before, request, self._rng, self._stats):
            if self._budget.exhausted:
                return False
            accept = None if guided else self._lessens(request.region, before)
            if self._run.commit(action, accept):
                self._done.append(action)
                return True
        return False

    def _lessens(self, region: SweptRegion, before: SceneState) -> Callable[[SceneState], bool]:
        rank = occupancy(self._s._problem, before, region)
        return lambda after: occupancy(self._s._problem, after, region) < rank


def _moves(path: Array) -> bool:
    return bool(np.linalg.norm(path[-1] - path[0]) > 1e-9)
