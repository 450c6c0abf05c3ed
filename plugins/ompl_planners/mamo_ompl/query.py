"""One query to OMPL. Everything of OMPL is made anew for it, and nothing outlives it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from ompl import base, geometric, util

from mamo_core.types.geometry import Array
from mamo_ompl.work import Work


def quiet() -> None:
    """Turn off OMPL's messages, which go to the terminal of the whole process."""
    util.setLogLevel(util.LogLevel.LOG_NONE)


def solve(
    planner: str,
    set_up: Callable[[Any], None],
    start: Array,
    goals: Array,
    bounds: tuple[Array, Array],
    work: Work,
    seed: int,
    optimize: bool,
) -> Array | None:
    """A path (k, dof) from ``start`` (dof,) to one of ``goals`` (m, dof), or None.

    ``planner``: a class of ``ompl.geometric``, prepared by ``set_up``. ``bounds``: lowest and
    highest joint positions (dof,) looked at, start and goals within. ``seed``: positive.

    OMPL says that its seed cannot be changed once random numbers were drawn, but what is made
    after ``RNG.setSeed`` is seeded from it nevertheless. So the same query gives the same path, if
    everything that holds a generator (spaces, samplers, planners) is made after it, as here, and
    no other thread uses OMPL meanwhile.
    """
    util.RNG.setSeed(seed)
    space = _space(bounds)
    information = _information(space, work)
    definition = base.ProblemDefinition(information)
    definition.addStartState(_state(space, start))
    region = base.GoalStates(information)
    for goal in goals:
        region.addState(_state(space, goal))
    definition.setGoal(region)
    definition.setOptimizationObjective(_objective(information, optimize))
    made = getattr(geometric, planner)(information)
    set_up(made)
    made.setProblemDefinition(definition)
    made.setup()
    made.solve(base.PlannerTerminationCondition(lambda: work.over))
    work.finish()
    if not definition.hasExactSolution():
        return None
    states = definition.getSolutionPath().getStates()
    return np.array([_values(state, start.size) for state in states])


def _space(bounds: tuple[Array, Array]) -> Any:
    low, high = bounds
    limits = base.RealVectorBounds(low.size)
    limits.low, limits.high = low.tolist(), high.tolist()
    space = base.RealVectorStateSpace(low.size)
    space.setBounds(limits)
    return space


def _information(space: Any, work: Work) -> Any:
    """The space with our checker; whole motions are one question, in the checker's own steps."""
    dof = space.getDimension()
    information = base.SpaceInformation(space)
    information.setStateValidityChecker(lambda state: work.free(_values(state, dof)))
    information.setMotionValidator(_Edges(information, work, dof))
    information.setup()
    return information


class _Edges(base.MotionValidator):  # type: ignore[misc]
    """Our checker's answer for whole motions. Must not hold ``information``, which holds it."""

    def __init__(self, information: Any, work: Work, dof: int) -> None:
        super().__init__(information)
        self._work, self._dof = work, dof

    def checkMotion(self, start: Any, end: Any) -> bool:
        return self._work.edge_free(_values(start, self._dof), _values(end, self._dof))


def _objective(information: Any, optimize: bool) -> Any:
    """Length; any path is short enough, or none ever is."""
    objective = base.PathLengthOptimizationObjective(information)
    objective.setCostThreshold(base.Cost(0.0 if optimize else float("inf")))
    return objective


def _state(space: Any, configuration: Array) -> Any:
    state = space.allocState()
    for index, value in enumerate(configuration.tolist()):
        state[index] = value
    return state


def _values(state: Any, dof: int) -> Array:
    """A copy (dof,): OMPL reuses the state as soon as a callback returns, and checks no index."""
    return np.array([state[index] for index in range(dof)])
