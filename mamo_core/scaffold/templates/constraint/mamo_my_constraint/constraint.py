"""The constraint: movable objects stay near where they stood.

To make it yours, change ``violations``. Every engine calls it after every simulated step.
"""

from __future__ import annotations

import numpy as np
from pydantic import Field

from mamo_core.hookspecs import Options
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import StepObservation, Violation

NAME = "my_constraint"


class MyConstraintOptions(Options):
    """What a problem may set, under ``options``."""

    limit: float = Field(default=0.3, gt=0.0, description="largest distance from the start, m")


class MyConstraint(InteractionConstraint):
    """No movable object leaves its place by more than ``limit``, seen from above."""

    def __init__(self, problem: Problem, options: MyConstraintOptions) -> None:
        self._names = [item.name for item in problem.scene.objects]
        self._places = list(problem.scene.movable_indices)
        self._start = problem.initial.object_poses[self._places, :2]
        self._limit = options.limit

    def violations(self, step: StepObservation) -> list[Violation]:
        """The objects beyond the limit at this step: EDIT HERE.

        It must depend on ``step`` alone, and be quick: it is asked thousands of times for a push.
        """
        distances = np.linalg.norm(step.positions[self._places, :2] - self._start, axis=1)
        return [
            Violation(
                constraint=NAME,
                subject=self._names[self._places[i]],
                other=None,
                time=step.time,
                value=float(distances[i]),
                limit=self._limit,
            )
            for i in np.flatnonzero(distances > self._limit)
        ]
