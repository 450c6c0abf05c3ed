"""What every search over rearrangements does: draw an NGR, ask MAPF, execute, try to retrieve."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mamo_core.interfaces.action_generator import ActionGenerator, ActionRequest
from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.interfaces.retrieval import RetrievalPlanner
from mamo_core.interfaces.search_strategy import ProgressCallback
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Array
from mamo_core.types.mapf import GoalPenalty, MAPFBudget
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Budget, Plan, Solution, SolutionStatus, Statistics
from mamo_planners.search.abstraction import mapf_problem, occupancy
from mamo_planners.search.execution import Execution, ExecutionFactory
from mamo_planners.search.judging import Accept
from mamo_planners.search.stand import Stand

if TYPE_CHECKING:
    from mamo_core.verify import VerifyReport

Actions = tuple[RearrangementAction, ...]
Paths = dict[str, Array]
Penalties = Mapping[str, Sequence[GoalPenalty]]
Verifier = Callable[
    [Plan, ParameterOverrides | None, Sequence[RolloutResult] | None], "VerifyReport"
]
"""Checks every claim of a plan, with the masses and frictions that the search believes in, and with
what the first engine did: it has executed the plan continuously, which need not be repeated."""


@dataclass(frozen=True, eq=False)
class SearchParts:
    """What a search works with."""

    problem: Problem
    retrieval: RetrievalPlanner
    mapf: MAPFSolver | None
    actions: tuple[tuple[str, ActionGenerator], ...]
    execution: ExecutionFactory
    verifier: Verifier

    @property
    def target_name(self) -> str:
        """The object to retrieve."""
        scene = self.problem.scene
        return scene.objects[scene.target_index].name


class SearchRun:
    """One call of ``solve``: the parts with its budget, generator and statistics.

    ``grasp_tries``: retrievals tried at one state. ``goal_margin``: of MAPF goals to the NGR, m.
    """

    def __init__(
        self,
        parts: SearchParts,
        budget: Budget,
        rng: np.random.Generator,
        progress: ProgressCallback,
        grasp_tries: int,
        mapf_budget: MAPFBudget,
        goal_margin: float,
    ) -> None:
        self.parts, self.budget, self.rng, self.progress = parts, budget, rng, progress
        self.statistics = Statistics()
        self._retrieval = parts.retrieval
        self.execution: Execution = parts.execution(self.statistics, budget, rng)
        self._mapf_budget, self._goal_margin = mapf_budget, goal_margin
        self._grasp_tries = grasp_tries

    def look_harder(self) -> None:
        """From now on retrieval looks at more grasps, which is slow to begin with."""
        with self.statistics.timed("retrieval"):
            self._retrieval = self._retrieval.thorough()

    def region(self, draws: int) -> SweptRegion | None:
        """The NGR of the retrieval, of some drawn, whose way is blocked the least.

        No more are drawn once an NGR has no more objects in it than were drawn: to push
        one or two objects aside takes about as long as to look for a better one.
        """
        best: tuple[tuple[int, float], SweptRegion] | None = None
        problem = self.parts.problem
        for drawn in range(1, draws + 1):
            motion = self.retrieval_without_movables()
            if motion is None:
                continue
            region = self.swept_by(motion)
            rank = occupancy(problem, problem.initial, region)
            if best is None or rank < best[0]:
                best = (rank, region)
            if best[0][0] <= drawn:
                break
        return best[1] if best is not None else None

    def retrieval_without_movables(self) -> Motion | None:
        """A retrieval from the initial scene as if it had no movables; why not is counted."""
        initial = self.parts.problem.initial
        with self.statistics.timed("retrieval"):
            found = self._retrieval.plan(initial, self.rng, ignore_movables=True)
        if found.motion is None:
            for cause, times in found.causes.items():
                self.statistics.failed(self.parts.target_name, "retrieval", cause, times)
        return found.motion

    def swept_by(self, retrieval: Motion) -> SweptRegion:
        """The NGR of a retrieval."""
        with self.statistics.timed("retrieval"):
            return self._retrieval.swept_region(self.parts.problem.initial, retrieval)

    def retrieve(self, stand: Stand, done: Actions, region: SweptRegion | None) -> Plan | None:
        """A verified plan if the target can be taken out now; failing grasps are left aside."""
        avoid: set[int] = set()
        for _ in range(self._grasp_tries):
            with self.statistics.timed("retrieval"):
                self.statistics.counts["retrievals"] += 1
                found = self._retrieval.plan(stand.state, self.rng, avoid=avoid)
            if found.motion is None or self.budget.exhausted:
                return None
            plan = self.confirmed(stand, done, found.motion, region)
            if plan is not None:
                return plan
            avoid.add(found.grasp)
        return None

    def confirmed(
        self, stand: Stand, done: Actions, retrieval: Motion, region: SweptRegion | None
    ) -> Plan | None:
        """The plan that ends with ``retrieval``, if it executes and is verified."""
        motion = self.execution.retrieval_from(stand, retrieval, self.rng)
        executed = self.execution.retrieved(stand, motion) if motion is not None else None
        if motion is None or executed is None:
            return None
        plan = Plan(done, motion, region)
        with self.statistics.timed("verification"):
            report = self.parts.verifier(plan, stand.leading.engine.parameters, executed)
        self.statistics.charge("verification", report.outside_cpu)
        self.budget.charge(report.outside_cpu)
        for failure in report.failures:
            self.statistics.failed("plan", "verification", failure)
        return plan if report.ok else None

    def paths(self, state: SceneState, region: SweptRegion, penalties: Penalties) -> Paths:
        """Where MAPF wants objects to go; empty if it finds nothing or nobody has to move."""
        if self.parts.mapf is None:
            raise ValueError("paths: this search was built without a MAPF solver")
        problem = mapf_problem(self.parts.problem, state, region, penalties, self._goal_margin)
        with self.statistics.timed("mapf"):
            solution = self.parts.mapf.solve(problem, self._mapf_budget, self.rng)
        self.statistics.counts["mapf_calls"] += 1
        self.statistics.counts[f"mapf_{solution.status}"] += 1
        for name, reason in solution.blame.items():
            self.statistics.failed(name, "mapf", reason)
        return {n: p for n, p in solution.paths.items() if len(p) > 1 and _moves(p)}

    def realise(
        self,
        stand: Stand,
        kind: str,
        request: ActionRequest,
        accept: Accept | None = None,
        failed: list[RearrangementAction] | None = None,
    ) -> tuple[RearrangementAction, Stand] | None:
        """The first action of a kind that is valid, and where it leads.

        What the generator itself says about progress goes before ``accept``. ``failed``: what this
        kind tried at this rearrangement before, and what fails now; the like is not tried again.
        """
        failed = failed if failed is not None else []
        generator = next(g for name, g in self.parts.actions if name == kind)
        accept = generator.progress(stand.state, request) or accept
        proposals = generator.propose(stand.state, request, self.rng, self.statistics)
        for action in proposals:
            if self.budget.exhausted:
                return None
            if any(generator.alike(action, other) for other in failed):
                self.statistics.counts["passed_over"] += 1
                continue
            after = self.execution.after(stand, action, accept)
            if after is not None:
                return action, after
            failed.append(action)
        return None

    def lessens(self, region: SweptRegion, before: SceneState) -> Accept:
        """Whether a state leaves less of the region occupied than ``before``."""
        problem = self.parts.problem
        rank = occupancy(problem, before, region)
        return lambda after: occupancy(problem, after, region) < rank

    def no_plan(self) -> Solution:
        """The end of a search that found nothing."""
        why = "no plan within the budget" if self.budget.exhausted else "nothing is left to try"
        return Solution(SolutionStatus.BUDGET_EXHAUSTED, None, self.statistics, why)

    def no_retrieval(self) -> Solution:
        """The end of a search that found no retrieval even without the movables."""
        name = self.parts.target_name
        prefix = f"{name}/retrieval/"
        causes = {
            key.removeprefix(prefix): times
            for key, times in self.statistics.causes.items()
            if key.startswith(prefix) and times
        }
        worst = max(causes, key=lambda cause: causes[cause], default="no grasp given")
        words = f"no way to retrieve {name} even without movables: {worst}"
        proved = set(causes) <= {"out_of_reach", "gripper_too_small"}
        status = SolutionStatus.NO_PLAN_PROVED if proved else SolutionStatus.BUDGET_EXHAUSTED
        return Solution(status, None, self.statistics, words)


def _moves(path: Array) -> bool:
    return bool(np.linalg.norm(path[-1] - path[0]) > 1e-9)
