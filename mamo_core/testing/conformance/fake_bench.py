"""The fast fake on the bench: what the suite itself is tested with."""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor

from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.robots.model import ArmModel
from mamo_core.testing.conformance.bench import Bench
from mamo_core.testing.gantry import GantryKinematics
from mamo_core.testing.gantry_arm import gantry_arm
from mamo_core.testing.quasi_static import QuasiStaticModel
from mamo_core.testing.transition_cases import gantry_cases, standard_constraints
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import RolloutResult


def quasi_static_bench() -> Bench:
    """The quasi-static model, which keeps all promises that are not about dynamics."""
    return Bench(
        make=_make,
        make_default=_make,
        in_new_process=_in_new_process,
        capabilities=QuasiStaticModel.capabilities,
        arm=gantry_arm(),
        cases=gantry_cases(),
    )


def _make(
    problem: Problem, _: ArmModel, constraints: tuple[InteractionConstraint, ...]
) -> QuasiStaticModel:
    return QuasiStaticModel(problem, GantryKinematics().forward, constraints)


def _in_new_process(problem: Problem, motion: Motion) -> RolloutResult:
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        return pool.submit(_rollout, problem, motion).result()


def _rollout(problem: Problem, motion: Motion) -> RolloutResult:
    model = _make(problem, gantry_arm(), standard_constraints(problem))
    return model.rollout(problem.initial, motion)
