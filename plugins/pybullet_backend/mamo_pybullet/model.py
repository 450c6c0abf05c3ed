"""The PyBullet transition model."""

from __future__ import annotations

from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.robots.model import ArmModel
from mamo_core.simulation.model import SimulatedModel
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides
from mamo_pybullet.engine import PyBulletWorld
from mamo_pybullet.options import PyBulletOptions
from mamo_pybullet.world import bodies_of


def make_model(
    problem: Problem,
    arm: ArmModel,
    constraints: tuple[InteractionConstraint, ...],
    options: PyBulletOptions,
) -> SimulatedModel:
    """PyBullet in this process."""

    def world(parameters: ParameterOverrides | None) -> PyBulletWorld:
        return PyBulletWorld(bodies_of(problem, arm, options, parameters))

    return SimulatedModel(problem, arm, constraints, world)
