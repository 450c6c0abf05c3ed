"""Trees of executions: where the arm went, what it pushed, and what the task demands at a goal."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from mamo_core.types.geometry import Array
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Budget, Plan, Statistics
from mamo_planners.baselines.sampling.options import SamplingOptions
from mamo_planners.reaching.goals import Goal, Goals
from mamo_planners.reaching.motions import Motions
from mamo_planners.reaching.shortcuts import straightened
from mamo_planners.reaching.stand import Executions, ReachingParts, Stand


@dataclass(eq=False)
class Node:
    """A state of arm and objects: what was executed, and how the arm goes on without contact.

    ``way`` (k, dof): from where the execution stands to where the arm is, touching nothing; one
    row where all was executed.
    """

    stand: Stand
    way: Array
    arrived: Stand | None = field(default=None, repr=False)

    @property
    def configuration(self) -> Array:
        """Where the arm is (dof,)."""
        return self.way[-1]

    @property
    def state(self) -> SceneState:
        """Arm and objects."""
        return self.stand.state.with_joints(self.way[-1])


class Growth:
    """Makes nodes of nodes; counts ``motions`` as it simulates them."""

    def __init__(
        self,
        parts: ReachingParts,
        options: SamplingOptions,
        goals: Goals,
        statistics: Statistics,
        budget: Budget,
        rng: np.random.Generator,
    ) -> None:
        self.options, self.goals, self.rng = options, goals, rng
        self.kinematics, self.statistics = parts.kinematics, statistics
        self.low, self.high = parts.arm.around_home
        self._start = parts.problem.initial.joint_positions
        self._budget = budget
        self._motions = Motions(parts.arm, parts.kinematics, options, goals.opening)
        self._executions = Executions(parts, statistics, budget)

    @property
    def over(self) -> bool:
        """Whether the time or the motions are used up."""
        used_up = self.statistics.counts["motions"] >= self.options.motions
        return used_up or self._budget.exhausted

    def root(self) -> Node | None:
        """At the start, the hand open; None where even that breaks a constraint."""
        stand = self._executions.start(self._motions.opened(self._start))
        return None if stand is None else Node(stand, self._start[None])

    def pushed(self, node: Node, q: Array) -> Node | None:
        """The arm goes straight to ``q`` (dof,) whatever is there; None where it must not."""
        self.statistics.counts["motions"] += 1
        stand = self._arrived(node)
        if stand is None:
            return None
        after = self._executions.after(stand, self._motions.sweep(np.stack([node.way[-1], q])))
        return None if after is None else Node(after, q[None])

    def went(self, node: Node, q: Array) -> Node:
        """The arm goes straight to ``q`` (dof,), where nothing is in the way: not simulated."""
        return replace(node, way=np.vstack([node.way, q]), arrived=None)

    def finished(self, node: Node, goal: Goal) -> Plan | None:
        """A verified plan by way of ``node``, which is at the goal, if there is one."""
        self.statistics.counts["goals_reached"] += 1
        stand = self._arrived(node)
        return None if stand is None else self._executions.finished(stand, goal, self.rng)

    def tool(self, q: Array) -> Array:
        """Where the tool is (3,), m, world: what KPIECE looks at."""
        return self.kinematics.forward(q)[:3, 3]

    def to_goal(self, q: Array) -> float:
        """Distance (m) of the tool to the nearest pre-grasp."""
        return float(np.linalg.norm(self.goals.tools[:, :3, 3] - self.tool(q), axis=1).min())

    def _arrived(self, node: Node) -> Stand | None:
        """The execution up to the node, made when it is needed first."""
        if len(node.way) == 1:
            return node.stand
        if node.arrived is None:
            world = self.goals.with_everything(node.stand.state)
            transit = self._motions.transit(straightened(node.way, world))
            node.arrived = self._executions.after(node.stand, transit)
        return node.arrived


def strided(start: Array, end: Array, stride: float) -> Array:
    """Places (k, dof) on the straight way, the last at ``end``, no joint moving over ``stride``.

    None at all where start and end are the same.
    """
    count = int(np.ceil(np.abs(end - start).max() / stride - 1e-9))
    return start + np.linspace(0.0, 1.0, count + 1)[1:, None] * (end - start)
