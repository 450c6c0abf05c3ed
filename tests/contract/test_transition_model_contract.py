"""The fake world keeps the contract; fakes that break one promise each fail that test."""

from __future__ import annotations

from mamo_core.testing.gantry import GantryKinematics
from mamo_core.testing.quasi_static import QuasiStaticModel
from mamo_core.testing.transition_cases import (
    TransitionCases,
    gantry_cases,
    standard_constraints,
)
from mamo_core.testing.transition_contract import TransitionModelContract
from mamo_core.types.problem import Problem


def quasi_static(problem: Problem) -> QuasiStaticModel:
    return QuasiStaticModel(problem, GantryKinematics().forward, standard_constraints(problem))


class TestQuasiStaticModel(TransitionModelContract):
    capabilities = QuasiStaticModel.capabilities

    def make_model(self, problem: Problem) -> QuasiStaticModel:
        return quasi_static(problem)

    def make_cases(self) -> TransitionCases:
        return gantry_cases()
