"""E-M4M and I-M4M: graphs over rearrangements, one NGR after the other (thesis ch. 5, 6)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from mamo_core.interfaces.search_strategy import ProgressCallback, SearchStrategy
from mamo_core.types.mapf import MAPFBudget
from mamo_core.types.region import SweptRegion
from mamo_core.types.solution import Budget, Plan, Solution, SolutionStatus
from mamo_planners.search.goals import Failure, GoalMemory
from mamo_planners.search.graph import GraphRules, RearrangementGraph
from mamo_planners.search.options import GraphOptions
from mamo_planners.search.orders import MakeOrder
from mamo_planners.search.push_database import PushDatabase
from mamo_planners.search.run import SearchParts, SearchRun
from mamo_planners.search.vertices import Vertex

Watch = Callable[[SweptRegion, Sequence[Vertex]], None]
"""Shown every graph when it is left: its NGR, and its vertices in the order they were found."""


class RearrangementSearch(SearchStrategy):
    """``make_order`` says which vertex comes first."""

    def __init__(self, parts: SearchParts, make_order: MakeOrder, options: GraphOptions) -> None:
        self._parts, self._make_order, self._options = parts, make_order, options

    def solve(
        self,
        budget: Budget,
        rng: np.random.Generator,
        progress: ProgressCallback,
        watch: Watch = lambda region, vertices: None,
    ) -> Solution:
        run = self._run(budget, rng, progress)
        start = run.execution.start
        plan = run.retrieve(start, (), None)
        failures: list[Failure] = []
        hopeless = 0
        for number in range(self._options.regions):
            if plan is not None or budget.exhausted:
                break
            region = run.region(self._options.draws if number == 0 else 1)
            if region is None:
                hopeless += 1
                if hopeless >= self._options.hopeless_regions:
                    return run.no_retrieval()
                continue
            run.statistics.counts["regions"] += 1
            order = self._make_order(self._parts.problem, region)
            database = self._database(run)
            rules = self._rules(number)
            graph = RearrangementGraph(run, region, order, rules, database, failures)
            plan = graph.search(start)
            watch(region, graph.vertices)
            plan = plan or self._grasped_anew(run)
        if plan is None:
            return run.no_plan()
        return Solution(SolutionStatus.SOLVED, plan, run.statistics)

    def _grasped_anew(self, run: SearchRun) -> Plan | None:
        """Grasps are drawn: what failed at the start may work the next time."""
        return run.retrieve(run.execution.start, (), None)

    def _run(
        self, budget: Budget, rng: np.random.Generator, progress: ProgressCallback
    ) -> SearchRun:
        options = self._options
        return SearchRun(
            self._parts,
            budget,
            rng,
            progress,
            options.grasp_tries,
            MAPFBudget(options.mapf_nodes, options.mapf_expansions),
            options.goal_margin,
        )

    def _database(self, run: SearchRun) -> PushDatabase | None:
        if not self._options.positive_database:
            return None
        return PushDatabase(self._parts.problem, run.execution.keeps_clear)

    def _rules(self, number: int) -> GraphRules:
        """Later graphs may become larger, so that no graph is left for good."""
        options = self._options
        weight = options.penalty if options.negative_database else 0.0
        return GraphRules(
            lazy=options.lazy,
            memory=GoalMemory(options.forbidden_radius, weight, options.shared_penalty),
            costs=options.costs,
            patience=options.patience,
            agnostic=options.agnostic,
            expansions=options.expansions,
            visits=options.visits * (1 + number),
            max_actions=options.max_actions,
        )
