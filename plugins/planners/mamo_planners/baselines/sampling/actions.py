"""What the planners of OMPL do: every action is simulated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mamo_core.types.geometry import Array
from mamo_core.types.solution import Plan
from mamo_planners.baselines.sampling.growth import Growth, Node, strided
from mamo_planners.reaching.goals import Goal, Goals

INVALID = -1
"""The number of what no node stands for."""

NextGoal = Callable[[], Goal]


@dataclass(eq=False)
class Actions:
    """Nodes by number, the root first. ``plan``: verified, ends at node ``solved``."""

    growth: Growth
    nodes: list[Node]
    next_goal: NextGoal
    plan: Plan | None = None
    solved: int = INVALID
    error: BaseException | None = None

    @property
    def over(self) -> bool:
        """Whether to stop: a plan, an error, or nothing left to spend."""
        return self.plan is not None or self.error is not None or self.growth.over

    def apply(self, number: int, control: Array) -> int:
        """The node that a stretch of ``control`` leads to from a node, or INVALID.

        ``control`` (dof + 1,): a configuration to move towards; and a number in [0, 1] that says,
        below the goal bias, to move to a goal instead, all the way.

        Errors are kept, as they must not unwind through OMPL; all that follows is invalid.
        """
        if self.over or number == INVALID:
            return INVALID
        try:
            if control[-1] < self.growth.options.goal_bias:
                return self._to_goal(number)
            return self._towards(number, control[:-1])
        except BaseException as error:
            self.error = error
            return INVALID

    def finish(self) -> Plan | None:
        """The plan if there is one; raises what went wrong."""
        if self.error is not None:
            # Its traceback holds what OMPL holds, and OMPL holds this: let go, or nothing is freed.
            error, self.error = self.error, None
            try:
                raise error
            finally:
                del error
        return self.plan

    def _towards(self, number: int, target: Array) -> int:
        node = self.nodes[number]
        places = strided(node.configuration, target, self.growth.options.stride)
        return self._moved(number, places[0]) if len(places) else number

    def _to_goal(self, number: int) -> int:
        goal = self.next_goal()
        there = self._moved(number, goal.configuration)
        if there != INVALID:
            self.plan = self.growth.finished(self.nodes[there], goal)
            self.solved = there if self.plan is not None else INVALID
        return there

    def _moved(self, number: int, q: Array) -> int:
        node = self.nodes[number]
        if np.abs(node.configuration - q).max() < 1e-9:
            return number
        new = self.growth.pushed(node, q)
        if new is None:
            return INVALID
        self.nodes.append(new)
        return len(self.nodes) - 1


def goals_before(goals: Goals, count: int, rng: np.random.Generator) -> NextGoal:
    """K1: ``count`` goal configurations chosen once, each as likely (thesis 3.5.1)."""
    known = goals.known
    chosen = rng.permutation(len(known))[:count]
    return lambda: known[int(rng.choice(chosen))]


def goals_online(goals: Goals, rng: np.random.Generator) -> NextGoal:
    """K2: inverse kinematics with a random seed whenever a goal is needed (thesis 3.5.1)."""
    return lambda: goals.drawn(rng)
