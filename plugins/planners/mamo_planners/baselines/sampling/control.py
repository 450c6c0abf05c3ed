"""Planning with OMPL's control planners; all of OMPL is made anew for each call.

States are joint positions, tool position (m) and the number of a node, which holds what the engine
knows; only the joints count for distances, only the tool for projections.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from ompl import base, control, util

from mamo_core.types.geometry import Array
from mamo_core.types.solution import Plan
from mamo_planners.baselines.sampling.actions import INVALID, Actions

_JOINTS, _TOOL, _NUMBER = 0, 1, 2
_SEEDS = 2**31
_REACH = 3.0
"""Tool positions are within this of the world's origin in each direction, m; only a formality."""


def grown(planner: str, actions: Actions, cell: float = 0.1) -> Plan | None:
    """A plan by the class ``planner`` of ``ompl.control``; ``cell``: size of cells, m, which only
    KPIECE looks at.

    The same generator in ``actions`` gives the same plan: what OMPL makes after ``RNG.setSeed`` is
    seeded by it, although it says otherwise. No other thread may use OMPL meanwhile.
    """
    util.setLogLevel(util.LogLevel.LOG_NONE)
    growth = actions.growth
    util.RNG.setSeed(int(growth.rng.integers(1, _SEEDS)))
    space = _states(growth.low, growth.high, cell)
    information = control.SpaceInformation(space, _controls(space, growth.low, growth.high))
    information.setStateValidityChecker(lambda state: bool(state[_NUMBER][0] > INVALID))
    information.setStatePropagator(_propagator(actions))
    information.setMinMaxControlDuration(1, growth.options.strides)
    information.setPropagationStepSize(1.0)
    information.setup()
    definition = base.ProblemDefinition(information)
    start = space.allocState()
    _write(start, 0, actions)
    definition.addStartState(start)
    definition.setGoal(_Solved(information, actions))
    made = getattr(control, planner)(information)
    made.setProblemDefinition(definition)
    made.setup()
    made.solve(base.PlannerTerminationCondition(lambda: actions.over))
    return actions.finish()


class _Solved(base.GoalRegion):  # type: ignore[misc]
    """Only a verified plan is a goal; elsewhere the distance of the tool tells how near it is."""

    def __init__(self, information: Any, actions: Actions) -> None:
        super().__init__(information)
        self._actions = actions
        self.setThreshold(1e-9)

    def distanceGoal(self, state: Any) -> float:
        number = int(state[_NUMBER][0])
        if number == self._actions.solved:
            return 0.0
        nodes, growth = self._actions.nodes, self._actions.growth
        return 1e-3 + growth.to_goal(nodes[number].configuration)


def _propagator(actions: Actions) -> Any:
    size = actions.growth.low.size + 1

    def propagate(state: Any, chosen: Any, duration: float, result: Any) -> None:
        """OMPL reuses what it hands over: all is copied at once, and no index is checked."""
        asked = np.array([chosen[index] for index in range(size)])
        _write(result, actions.apply(int(state[_NUMBER][0]), asked), actions)

    return propagate


def _write(state: Any, number: int, actions: Actions) -> None:
    state[_NUMBER][0] = float(number)
    if number == INVALID:
        return
    q = actions.nodes[number].configuration
    for part, values in ((_JOINTS, q), (_TOOL, actions.growth.tool(q))):
        for index, value in enumerate(values.tolist()):
            state[part][index] = value


def _states(low: Array, high: Array, cell: float) -> Any:
    joints = _box(base.RealVectorStateSpace(low.size), low, high)
    tool = _box(base.RealVectorStateSpace(3), np.full(3, -_REACH), np.full(3, _REACH))
    number = _box(base.RealVectorStateSpace(1), np.array([-1.0]), np.array([1e9]))
    space = base.CompoundStateSpace([joints, tool, number], [1.0, 0.0, 0.0])
    position = base.RealVectorOrthogonalProjectionEvaluator(tool, [cell] * 3, [0, 1, 2])
    space.registerDefaultProjection(base.SubspaceProjectionEvaluator(space, _TOOL, position))
    return space


def _controls(space: Any, low: Array, high: Array) -> Any:
    """One dimension more says when to go to a goal: samplers cannot be written in Python."""
    made = control.RealVectorControlSpace(space, low.size + 1)
    return _box(made, np.append(low, 0.0), np.append(high, 1.0))


def _box(space: Any, low: Array, high: Array) -> Any:
    limits = base.RealVectorBounds(low.size)
    limits.low, limits.high = low.tolist(), high.tolist()
    space.setBounds(limits)
    return space
