"""Every transition model of ours keeps the contract that plugin authors test theirs with."""

from __future__ import annotations

from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.robots.library import load_arm
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


class TestMuJoCo(TransitionModelContract):
    capabilities = frozenset({"exact_continuation"})

    def make_model(self, problem: Problem) -> TransitionModel:
        from mamo_mujoco.model import MuJoCoModel
        from mamo_mujoco.options import MuJoCoOptions

        arm = load_arm(problem.scene.robot)
        return MuJoCoModel(problem, arm, standard_constraints(problem), MuJoCoOptions())


class TestPyBullet(TransitionModelContract):
    capabilities = frozenset({"exact_continuation"})

    def make_model(self, problem: Problem) -> TransitionModel:
        from mamo_pybullet.model import make_model
        from mamo_pybullet.options import PyBulletOptions

        arm = load_arm(problem.scene.robot)
        return make_model(problem, arm, standard_constraints(problem), PyBulletOptions())


class TestDART(TransitionModelContract):
    capabilities = frozenset({"exact_continuation"})

    def make_model(self, problem: Problem) -> TransitionModel:
        from mamo_dart.model import make_model
        from mamo_dart.options import DARTOptions

        arm = load_arm(problem.scene.robot)
        return make_model(problem, arm, standard_constraints(problem), DARTOptions())
