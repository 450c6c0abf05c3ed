"""What the conformance suite does not ask of engines: answers to bad input."""

from dataclasses import replace

import pytest

from mamo_core.errors import InputError
from mamo_core.plugins import discover
from mamo_core.testing.conformance.runner import bench_of
from mamo_core.testing.transition_cases import standard_constraints
from mamo_core.types.rollout import ParameterOverrides

ENGINES = ("mujoco", "pybullet", "dart")


@pytest.fixture(params=ENGINES)
def bench(request):
    return bench_of(discover().component("backend", request.param, "test"))


def test_parameters_of_an_unknown_object(bench):
    problem = bench.cases.problem
    model = bench.make(problem, bench.arm, standard_constraints(problem))
    with pytest.raises(KeyError, match="nobody"):
        model.rollout(
            problem.initial, bench.cases.still, parameters=ParameterOverrides({"nobody": 1.0})
        )
    with pytest.raises(KeyError, match="nobody"):
        model.rollout(
            problem.initial, bench.cases.still, parameters=ParameterOverrides({}, {"nobody": 1.0})
        )


def test_dart_refuses_a_fixture_that_changes_friction():
    bench = bench_of(discover().component("backend", "dart", "test"))
    problem = bench.cases.problem
    (board,) = problem.scene.fixtures
    scene = replace(problem.scene, fixtures=(replace(board, friction=0.5),))
    with pytest.raises(InputError, match="expected 1"):
        bench.make(replace(problem, scene=scene), bench.arm, ())
