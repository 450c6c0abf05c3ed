"""The DART transition model."""

from __future__ import annotations

from mamo_core.errors import InputError
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.robots.model import ArmModel
from mamo_core.simulation.model import SimulatedModel
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides
from mamo_dart.engine import DARTWorld
from mamo_dart.options import DARTOptions


def make_model(
    problem: Problem,
    arm: ArmModel,
    constraints: tuple[InteractionConstraint, ...],
    options: DARTOptions,
) -> SimulatedModel:
    """DART in this process.

    Raises:
        InputError: a fixture whose friction is not 1, as a pair gets the smaller coefficient here.
    """
    for fixture in problem.scene.fixtures:
        if fixture.friction != 1.0:
            raise InputError(
                f"backend 'dart': fixture {fixture.name!r} of problem {problem.name!r} has "
                f"friction {fixture.friction:g}, expected 1 (others need friction_product)"
            )

    def world(parameters: ParameterOverrides | None) -> DARTWorld:
        return DARTWorld(problem, arm, options, parameters)

    return SimulatedModel(problem, arm, constraints, world)
