"""Why objects cannot get out of the region that the retrieval sweeps, without any physics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.types.mapf import MAPFBudget, MAPFProblem, MAPFSolution, MAPFStatus
from mamo_core.types.solution import Statistics
from mamo_planners.diagnosis.sparing import indispensable

_SEED = 0


@dataclass(frozen=True, eq=False)
class PathFinder:
    """A MAPF solver with the work it is allowed; it has no paths where it runs out of that."""

    solver: MAPFSolver
    budget: MAPFBudget

    def solved(self, problem: MAPFProblem) -> MAPFSolution:
        """What the solver says, always the same."""
        return self.solver.solve(problem, self.budget, np.random.default_rng(_SEED))

    def fails(self, problem: MAPFProblem) -> bool:
        """Whether there are no paths, or none are found."""
        return not self.solved(problem).solved


def count_who_is_stuck(problem: MAPFProblem, finder: PathFinder, statistics: Statistics) -> None:
    """The agents to blame for a problem without paths, under their causes of ``mapf``.

    Involved are the obstacles that hem an agent in, none of which can be spared; where nobody is
    to blame alone, the agents that cannot all get out.
    """
    solution = finder.solved(problem)
    for name, reason in solution.blame.items():
        around = _hemming_in(problem, name, finder)
        statistics.failed(name, "mapf", reason, involved=around)
    if solution.blame:
        return
    proved = solution.status is MAPFStatus.INFEASIBLE
    together = _in_each_others_way(problem, finder)
    for name in together:
        others = tuple(other for other in together if other != name)
        statistics.failed(name, "mapf", "jammed" if proved else "no_paths_found", involved=others)


def _hemming_in(problem: MAPFProblem, name: str, finder: PathFinder) -> tuple[str, ...]:
    """Obstacles without any of which the agent could get out; none if the room itself is to blame.

    Those far away are spared first.
    """
    alone = replace(problem, agents=tuple(a for a in problem.agents if a.name == name))
    here = alone.agents[0].pose[:2]
    far_first = sorted(problem.obstacles, key=lambda o: -float(np.linalg.norm(o.pose[:2] - here)))

    def stuck(names: Sequence[str]) -> bool:
        among = tuple(o for o in problem.obstacles if o.name in names)
        return finder.fails(replace(alone, obstacles=among))

    return indispensable([o.name for o in far_first], stuck) or ()


def _in_each_others_way(problem: MAPFProblem, finder: PathFinder) -> tuple[str, ...]:
    """Agents that cannot all get out, none of which can be spared."""

    def stuck(names: Sequence[str]) -> bool:
        some = tuple(a for a in problem.agents if a.name in names)
        return finder.fails(replace(problem, agents=some))

    return indispensable([agent.name for agent in problem.agents], stuck) or ()
