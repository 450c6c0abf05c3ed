"""When the constraint speaks and when it does not: by hand, and in a small world."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mamo_core.interfaces.action_generator import ActionRequest
from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.plugins import discover
from mamo_core.problems import load_problem
from mamo_core.testing.fakes import StraightPush, StraightRetrieval
from mamo_core.testing.gantry import GantryKinematics
from mamo_core.testing.quasi_static import QuasiStaticModel
from mamo_core.testing.scenes import one_blocker
from mamo_core.types.geometry import Array, z_axes
from mamo_core.types.rollout import NO_CONTACTS, NO_DEPTHS, StepObservation, Violation
from mamo_core.types.solution import Statistics
from mamo_my_constraint.constraint import NAME, MyConstraint, MyConstraintOptions

PROBLEM = one_blocker().problem
A = PROBLEM.scene.index("a")


def seen(poses: Array, held: int = -1) -> StepObservation:
    """A step at 1 s in which everything stands still at ``poses`` (n, 7)."""
    positions = poses[:, :3]
    still = 0.0 * positions
    return StepObservation(1.0, positions, z_axes(poses), still, NO_CONTACTS, NO_DEPTHS, held)


def found(limit: float, shift: float, place: int = A) -> list[Violation]:
    """What is said when one object has moved by ``shift`` m."""
    poses = np.array(PROBLEM.initial.object_poses)
    poses[place, 1] += shift
    return MyConstraint(PROBLEM, MyConstraintOptions(limit=limit)).violations(seen(poses))


def test_nothing_is_said_at_the_start() -> None:
    assert found(0.1, 0.0) == []


def test_it_names_who_is_beyond_the_limit_and_by_how_much() -> None:
    (violation,) = found(0.1, 0.15)
    assert (violation.constraint, violation.subject, violation.time) == (NAME, "a", 1.0)
    assert violation.value == pytest.approx(0.15)
    assert str(violation) == f"{NAME}: a at 1.000 s (0.15 > 0.1)"


def test_it_is_silent_below_the_limit() -> None:
    assert found(0.1, 0.09) == []


def test_the_target_may_be_carried_away() -> None:
    assert found(0.1, 1.0, PROBLEM.scene.target_index) == []


@pytest.mark.parametrize(("limit", "broken"), [(0.05, True), (0.3, False)])
def test_a_rollout_reports_it(limit: float, broken: bool) -> None:
    """A push by 15 cm in the fast fake of an engine."""
    constraint = MyConstraint(PROBLEM, MyConstraintOptions(limit=limit))
    model = QuasiStaticModel(PROBLEM, GantryKinematics().forward, [constraint])
    rng = np.random.default_rng(0)
    retrieval = StraightRetrieval(PROBLEM)
    way = retrieval.plan(PROBLEM.initial, rng, ignore_movables=True).motion
    assert way is not None
    request = ActionRequest("a", None, retrieval.swept_region(PROBLEM.initial, way))
    push = next(StraightPush(PROBLEM).propose(PROBLEM.initial, request, rng, Statistics()))
    result = model.rollout(PROBLEM.initial, push.motion, options=RolloutOptions(stop_early=False))
    assert [v.subject for v in result.violations] == (["a"] if broken else [])


def test_the_problem_beside_it_uses_it() -> None:
    problem = load_problem(Path(__file__).parents[1] / "problem.yaml")
    component = discover().component("constraint", NAME)
    (options,) = [spec.options for spec in problem.constraints if spec.name == NAME]
    assert component.options(**options)
