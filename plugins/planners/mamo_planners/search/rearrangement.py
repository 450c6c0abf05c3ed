"""E-M4M and I-M4M: graphs over rearrangements, one NGR after the other (thesis ch. 5, 6)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from mamo_core.interfaces.search_strategy import ProgressCallback, SearchStrategy
from mamo_core.types.mapf import MAPFBudget
from mamo_core.types.region import SweptRegion
from mamo_core.types.search_graph import GRAPHS, SearchGraph
from mamo_core.types.solution import Budget, Plan, Solution, SolutionStatus, Statistics
from mamo_planners.diagnosis import diagnose
from mamo_planners.search.attempts import at_once
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
        best = run.retrieve(start, (), None)
        graphs = [at_once(start.state)] if best is not None else []
        failures: list[Failure] = []
        hopeless = since_best = 0
        for number in range(self._options.regions):
            if budget.exhausted or self._good_enough(best, since_best):
                break
            if number == self._options.thorough_after:
                run.look_harder()
            region = run.region(self._options.draws if number == 0 else 1)
            if region is None:
                hopeless, since_best = hopeless + 1, since_best + 1
                if best is None and hopeless >= self._options.hopeless_regions:
                    return _with_graphs(run.no_retrieval(), graphs)
                continue
            run.statistics.counts["regions"] += 1
            order = self._make_order(self._parts.problem, region)
            rules, database = self._rules(number, best), self._database(run)
            graph = RearrangementGraph(run, region, order, rules, database, failures)
            plan = graph.search(start)
            watch(region, graph.vertices)
            graphs.append(graph.record)
            if plan is None and best is None:
                # Grasps are drawn: what failed at the start may work the next time.
                plan = run.retrieve(start, (), None)
                graphs += [at_once(start.state)] if plan is not None else []
            since_best = 0 if plan is not None else since_best + 1
            best = plan or best
        if best is None:
            return _with_graphs(run.no_plan(), graphs)
        return _with_graphs(Solution(SolutionStatus.SOLVED, best, run.statistics), graphs)

    def diagnose(self, solution: Solution) -> Statistics:
        return diagnose(self._parts, solution, self._mapf_budget, self._options.goal_margin)

    def _good_enough(self, best: Plan | None, since_best: int) -> bool:
        """Whether to stop, so many NGRs after the best plan was found.

        Nothing is better than one action: without any the target could not be taken out.
        """
        return best is not None and (len(best.actions) <= 1 or since_best >= self._options.improve)

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
            self._mapf_budget,
            options.goal_margin,
        )

    @property
    def _mapf_budget(self) -> MAPFBudget:
        return MAPFBudget(self._options.mapf_nodes, self._options.mapf_expansions)

    def _database(self, run: SearchRun) -> PushDatabase | None:
        if not self._options.positive_database:
            return None
        return PushDatabase(self._parts.problem, run.execution.keeps_clear)

    def _rules(self, number: int, best: Plan | None) -> GraphRules:
        """Later graphs may become larger, so that no graph is left for good.

        Only plans with fewer actions than the best one are looked for.
        """
        options = self._options
        most = options.max_actions if best is None else len(best.actions) - 1
        weight = options.penalty if options.negative_database else 0.0
        return GraphRules(
            lazy=options.lazy,
            memory=GoalMemory(options.forbidden_radius, weight, options.shared_penalty),
            costs=options.costs,
            patience=options.patience,
            agnostic=options.agnostic,
            expansions=options.expansions,
            visits=options.visits * (1 + number),
            max_actions=most,
        )


def _with_graphs(solution: Solution, graphs: Sequence[SearchGraph]) -> Solution:
    return replace(solution, info={GRAPHS: tuple(graphs)})
