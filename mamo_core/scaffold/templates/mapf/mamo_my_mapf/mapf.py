"""The solver: one agent after the other, each by the cheapest walk past those before it.

To make it yours, change ``solve``: it decides who goes first, and who next when one finds no way.
``walk.py`` finds the walk of one agent, ``gaps.py`` knows who would be too near to whom. Objects
are taken as upright.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydantic import Field

from mamo_core.hookspecs import Options
from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.types.mapf import MAPFAgent, MAPFBudget, MAPFProblem, MAPFSolution, MAPFStatus
from mamo_my_mapf.walk import OutOfWorkError, Passer, Walk, Work, walk

Walks = dict[str, Walk]


class MyMapfOptions(Options):
    """What a recipe may set: ``{name: my_mapf, orders: 20}``."""

    orders: int = Field(default=10, ge=1, description="orders of the agents to try")


class MyMapf(MAPFSolver):
    """Prioritised planning. It is not complete: it never says that there is no solution."""

    def __init__(self, options: MyMapfOptions) -> None:
        self._options = options

    def solve(
        self, problem: MAPFProblem, budget: MAPFBudget, rng: np.random.Generator
    ) -> MAPFSolution:
        """Paths for all agents, or TIMEOUT: EDIT HERE.

        Who stands in the region goes first; who finds no way goes first the next time.
        """
        agents = sorted(problem.agents, key=lambda agent: not _inside(problem, agent))
        work = Work(budget.expansions)
        nodes = 0
        try:
            while nodes < min(self._options.orders, budget.nodes):
                nodes += 1
                walks, stuck = _in_turn(problem, agents, work)
                if stuck is None:
                    return _solution(walks, nodes, work)
                agents = [stuck, *(agent for agent in agents if agent is not stuck)]
        except OutOfWorkError:
            return MAPFSolution(MAPFStatus.TIMEOUT, nodes=nodes, expansions=work.done)
        return MAPFSolution(MAPFStatus.TIMEOUT, nodes=nodes, expansions=work.done)


def _inside(problem: MAPFProblem, agent: MAPFAgent) -> bool:
    return problem.region.overlaps(agent.shape, agent.pose)


def _in_turn(
    problem: MAPFProblem, agents: Sequence[MAPFAgent], work: Work
) -> tuple[Walks, MAPFAgent | None]:
    """Walks of the agents in this order, and the first one that finds no way, if there is one."""
    walks: Walks = {}
    for number, agent in enumerate(agents):
        before = [Passer(problem, agent, other, walks[other.name]) for other in agents[:number]]
        found = walk(problem, agent, before, work)
        if found is None:
            return walks, agent
        walks[agent.name] = found
    return walks, None


def _solution(walks: Walks, nodes: int, work: Work) -> MAPFSolution:
    cost = sum(found.cost for found in walks.values())
    nobody_moves = cost == 0.0  # nothing is cheaper; of all else only the paths are claimed
    return MAPFSolution(
        MAPFStatus.OPTIMAL if nobody_moves else MAPFStatus.FEASIBLE,
        paths={name: found.path for name, found in walks.items()},
        cost=cost,
        bound=1.0 if nobody_moves else float("inf"),
        nodes=nodes,
        expansions=work.done,
    )
