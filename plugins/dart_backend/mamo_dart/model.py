"""The DART transition model."""

from __future__ import annotations

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
    """DART in this process."""

    def world(parameters: ParameterOverrides | None) -> DARTWorld:
        return DARTWorld(problem, arm, options, parameters)

    return SimulatedModel(problem, arm, constraints, world)
