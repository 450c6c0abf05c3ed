"""The interaction constraints of the thesis (2.3.2), engine-neutral and vectorised.

Each looks at one step at a time; the monitor asks it only about steps beyond somebody's limits.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mamo_core.constraints.limits import LimitedConstraint, unlimited
from mamo_core.constraints.options import (
    BoundsOptions,
    PenetrationOptions,
    SpeedOptions,
    TiltOptions,
)
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ROBOT, StepObservation, Violation
from mamo_core.types.scene import Mobility


class ContactConstraint(LimitedConstraint):
    """Nothing touches an immovable object, nor the target before it is held; no arm on fixtures
    or on the robot itself.

    While the target is held the arm may touch it, and it may still touch the fixture it stood on;
    nothing else may. Engines with the capability ``clearance`` report that a movable object touches
    an immovable one or the target from ``clearance`` (m) on; others are not to be given any.
    """

    name = "contact"

    def __init__(self, problem: Problem, clearance: float = 0.0) -> None:
        self.clearance = clearance
        scene = problem.scene
        self._entities = scene.entities
        objects = len(scene.objects)
        target = 1 + scene.target_index
        count = len(self._entities)
        guarded = [1 + i for i, o in enumerate(scene.objects) if o.mobility is not Mobility.MOVABLE]
        fixtures = np.arange(1 + objects, count)
        free = np.zeros((count, count), dtype=np.bool_)
        for entity in guarded:
            others = [e for e in range(1 + objects) if e != entity]
            free[entity, others] = free[others, entity] = True
        free[ROBOT, fixtures] = free[fixtures, ROBOT] = True
        free[ROBOT, ROBOT] = True
        forbidden = np.repeat(free[None], 1 + objects, axis=0)
        # As entity it comes after the robot, in the limits after "nothing in hand".
        held = forbidden[target]
        held[ROBOT, target] = held[target, ROBOT] = False
        self.limits = replace(unlimited(problem), forbidden=forbidden)

    def violations(self, step: StepObservation) -> list[Violation]:
        hits = self.limits.forbidden[1 + step.held, step.contacts[:, 0], step.contacts[:, 1]]
        pairs = sorted({(int(a), int(b)) for a, b in step.contacts[hits]})
        return [
            Violation(self.name, self._entities[a], self._entities[b], step.time, 1.0, 0.0)
            for a, b in pairs
        ]


class TiltConstraint(LimitedConstraint):
    """The angle between a body's z axis now and at the problem's start stays below the limit."""

    name = "tilt"

    def __init__(self, problem: Problem, options: TiltOptions) -> None:
        self._names = [o.name for o in problem.scene.objects]
        self._limit = float(np.radians(options.limit_deg))
        self.limits = replace(unlimited(problem), cosine=float(np.cos(self._limit)))

    def violations(self, step: StepObservation) -> list[Violation]:
        cosines = np.einsum("ij,ij->i", step.z_axes, self.limits.axes)
        return [
            Violation(
                self.name,
                self._names[i],
                None,
                step.time,
                float(np.arccos(np.clip(cosines[i], -1.0, 1.0))),
                self._limit,
            )
            for i in np.flatnonzero(cosines < self.limits.cosine)
        ]


class SpeedConstraint(LimitedConstraint):
    """The norm of the velocity of an object's centre stays below the limit."""

    name = "speed"

    def __init__(self, problem: Problem, options: SpeedOptions) -> None:
        self._names = [o.name for o in problem.scene.objects]
        self._limit = options.limit
        self.limits = replace(unlimited(problem), square=options.limit**2)

    def violations(self, step: StepObservation) -> list[Violation]:
        squares = np.einsum("ij,ij->i", step.velocities, step.velocities)
        return [
            Violation(
                self.name, self._names[i], None, step.time, float(np.sqrt(squares[i])), self._limit
            )
            for i in np.flatnonzero(squares > self.limits.square)
        ]


class BoundsConstraint(LimitedConstraint):
    """No object falls: its centre does not sink by more than ``drop`` below its start height."""

    name = "bounds"

    def __init__(self, problem: Problem, options: BoundsOptions) -> None:
        self._names = [o.name for o in problem.scene.objects]
        self._drop = options.drop
        lowest = problem.initial.object_poses[:, 2] - options.drop
        self.limits = replace(unlimited(problem), lowest=lowest)

    def violations(self, step: StepObservation) -> list[Violation]:
        below = self.limits.lowest - step.positions[:, 2]
        return [
            Violation(
                self.name,
                self._names[i],
                None,
                step.time,
                float(below[i]) + self._drop,
                self._drop,
            )
            for i in np.flatnonzero((below > 0.0) & (np.arange(below.size) != step.held))
        ]


class PenetrationConstraint(LimitedConstraint):
    """Nothing reaches farther than ``limit`` into something else: contacts of engines are soft.

    The hand may press what is in it: how hard, the gripper's force says.
    """

    name = "penetration"

    def __init__(self, problem: Problem, options: PenetrationOptions) -> None:
        self._entities = problem.scene.entities
        self._limit = options.limit
        self.limits = replace(unlimited(problem), deepest=options.limit)

    def violations(self, step: StepObservation) -> list[Violation]:
        deepest: dict[tuple[int, int], float] = {}
        for (a, b), depth in zip(step.contacts.tolist(), step.depths.tolist(), strict=True):
            gripped = a == ROBOT and b == 1 + step.held
            if depth > self._limit and not gripped:
                deepest[a, b] = max(depth, deepest.get((a, b), 0.0))
        return [
            Violation(
                self.name, self._entities[a], self._entities[b], step.time, depth, self._limit
            )
            for (a, b), depth in sorted(deepest.items())
        ]
