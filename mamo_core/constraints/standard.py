"""The interaction constraints of the thesis (2.3.2), engine-neutral and vectorised.

Each looks at one step at a time; a quick test over whole arrays decides whether to look closer.
"""

from __future__ import annotations

import numpy as np

from mamo_core.constraints.kernels import deepest, largest_square, least_cosine
from mamo_core.constraints.options import BoundsOptions, SpeedOptions, TiltOptions
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ROBOT, StepObservation, Violation
from mamo_core.types.scene import Mobility


class ContactConstraint(InteractionConstraint):
    """Nothing touches an immovable object, nor the target before it is held; no arm on fixtures.

    While the target is held the arm may touch it, and it may still touch the fixture it stood on;
    nothing else may.
    """

    name = "contact"

    def __init__(self, problem: Problem) -> None:
        scene = problem.scene
        self._entities = scene.entities
        objects = len(scene.objects)
        self._target = 1 + scene.target_index
        count = len(self._entities)
        guarded = [1 + i for i, o in enumerate(scene.objects) if o.mobility is not Mobility.MOVABLE]
        fixtures = np.arange(1 + objects, count)
        free = np.zeros((count, count), dtype=np.bool_)
        for entity in guarded:
            others = [e for e in range(1 + objects) if e != entity]
            free[entity, others] = free[others, entity] = True
        free[ROBOT, fixtures] = free[fixtures, ROBOT] = True
        held = free.copy()
        held[ROBOT, self._target] = held[self._target, ROBOT] = False
        self._forbidden_free, self._forbidden_held = free, held

    def violations(self, step: StepObservation) -> list[Violation]:
        if not len(step.contacts):
            return []
        holding = step.held == self._target - 1
        forbidden = self._forbidden_held if holding else self._forbidden_free
        hits = forbidden[step.contacts[:, 0], step.contacts[:, 1]]
        if not hits.any():
            return []
        pairs = sorted({(int(a), int(b)) for a, b in step.contacts[hits]})
        return [
            Violation(self.name, self._entities[a], self._entities[b], step.time, 1.0, 0.0)
            for a, b in pairs
        ]


class TiltConstraint(InteractionConstraint):
    """The angle between a body's z axis now and at the problem's start stays below the limit."""

    name = "tilt"

    def __init__(self, problem: Problem, options: TiltOptions) -> None:
        self._names = [o.name for o in problem.scene.objects]
        self._reference = problem.initial_z_axes
        self._limit = float(np.radians(options.limit_deg))
        self._cosine = float(np.cos(self._limit))

    def violations(self, step: StepObservation) -> list[Violation]:
        if least_cosine(step.z_axes, self._reference) >= self._cosine:
            return []
        cosines = np.einsum("ij,ij->i", step.z_axes, self._reference)
        return [
            Violation(
                self.name,
                self._names[i],
                None,
                step.time,
                float(np.arccos(np.clip(cosines[i], -1.0, 1.0))),
                self._limit,
            )
            for i in np.flatnonzero(cosines < self._cosine)
        ]


class SpeedConstraint(InteractionConstraint):
    """The norm of the velocity of an object's centre stays below the limit."""

    name = "speed"

    def __init__(self, problem: Problem, options: SpeedOptions) -> None:
        self._names = [o.name for o in problem.scene.objects]
        self._limit = options.limit

    def violations(self, step: StepObservation) -> list[Violation]:
        if largest_square(step.velocities) <= self._limit**2:
            return []
        squares = np.einsum("ij,ij->i", step.velocities, step.velocities)
        return [
            Violation(
                self.name, self._names[i], None, step.time, float(np.sqrt(squares[i])), self._limit
            )
            for i in np.flatnonzero(squares > self._limit**2)
        ]


class BoundsConstraint(InteractionConstraint):
    """No object falls: its centre does not sink by more than ``drop`` below its start height."""

    name = "bounds"

    def __init__(self, problem: Problem, options: BoundsOptions) -> None:
        self._names = [o.name for o in problem.scene.objects]
        self._lowest = problem.initial.object_poses[:, 2] - options.drop
        self._drop = options.drop

    def violations(self, step: StepObservation) -> list[Violation]:
        if deepest(step.positions, self._lowest) <= 0.0:
            return []
        below = self._lowest - step.positions[:, 2]
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
