"""The engine keeps what it promises: the conformance suite, and one push of its own."""

from __future__ import annotations

import numpy as np
import pytest

from mamo_core.build_context import BuildContext
from mamo_core.compose import build_component
from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.plugins import discover
from mamo_core.testing.conformance.pytest_suite import BackendConformance
from mamo_core.testing.conformance.runner import scripted_cases
from mamo_core.testing.gantry_arm import gantry_arm
from mamo_core.testing.transition_cases import shift_along
from mamo_core.types.rollout import ParameterOverrides

NAME = "my_backend"


class TestConformance(BackendConformance):
    """Each check is a test; what the engine does not declare is skipped."""

    backend = NAME


@pytest.fixture
def model() -> TransitionModel:
    """The engine for a small scene in which a foot pushes a can."""
    component = discover().component("backend", NAME)
    context = BuildContext(scripted_cases().problem, gantry_arm())
    built: TransitionModel = build_component("backend", component, component.options(), context)
    return built


def test_a_push_moves_the_can_straight(model: TransitionModel) -> None:
    cases = scripted_cases()
    result = model.rollout(cases.problem.initial, cases.push)
    place = cases.problem.scene.index(cases.pushed)
    before, after = (
        state.object_poses[place] for state in (cases.problem.initial, result.final_state)
    )
    assert result.moved == (cases.pushed,)
    assert shift_along(before, after, np.array(cases.direction)) > 0.02
    assert abs(after[1] - before[1]) < 0.01


def test_what_is_too_heavy_stops_the_arm(model: TransitionModel) -> None:
    cases = scripted_cases()
    heavy = ParameterOverrides(masses={cases.pushed: 100.0})
    assert model.rollout(cases.problem.initial, cases.push, parameters=heavy).stalled
