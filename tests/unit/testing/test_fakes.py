from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from mamo_core.interfaces.action_generator import ActionRequest
from mamo_core.problems.checks import complaints
from mamo_core.testing.fakes import StraightPush, StraightRetrieval
from mamo_core.testing.gantry import GantryKinematics
from mamo_core.testing.quasi_static import QuasiStaticModel
from mamo_core.testing.scenes import (
    TinyScene,
    clear_scene,
    one_blocker,
    two_blockers,
    walled_in,
)
from mamo_core.testing.transition_cases import standard_constraints
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Statistics

SCENES: list[Callable[[], TinyScene]] = [clear_scene, one_blocker, two_blockers, walled_in]
RNG = np.random.default_rng(0)


def world(problem: Problem) -> QuasiStaticModel:
    return QuasiStaticModel(problem, GantryKinematics().forward, standard_constraints(problem))


def region_of(problem: Problem) -> SweptRegion:
    retrieval = StraightRetrieval(problem)
    motion = retrieval.plan(problem.initial, RNG, ignore_movables=True).motion
    assert motion is not None
    return retrieval.swept_region(problem.initial, motion)


def in_the_way(problem: Problem, state: SceneState) -> tuple[str, ...]:
    region = region_of(problem)
    return tuple(
        problem.scene.objects[i].name
        for i in problem.scene.movable_indices
        if region.overlaps(problem.scene.objects[i].shape, state.object_poses[i])
    )


@pytest.mark.parametrize("make", SCENES)
def test_scenes_are_valid(make: Callable[[], TinyScene]) -> None:
    assert complaints(make().problem) == []


@pytest.mark.parametrize("make", SCENES[:3])
def test_blockers_are_those_in_the_way(make: Callable[[], TinyScene]) -> None:
    scene = make()
    problem = scene.problem
    assert in_the_way(problem, problem.initial) == scene.blockers
    found = StraightRetrieval(problem).plan(problem.initial, RNG)
    assert (found.motion is None) == bool(scene.blockers)
    assert set(found.causes) == {f"blocked_by_{name}" for name in scene.blockers}


def test_walled_in_has_no_retrieval_at_all() -> None:
    problem = walled_in().problem
    found = StraightRetrieval(problem).plan(problem.initial, RNG, ignore_movables=True)
    assert found.motion is None
    assert found.causes == {"blocked_by_w": 1}


def test_a_clear_retrieval_holds_in_the_fake_world() -> None:
    problem = clear_scene().problem
    motion = StraightRetrieval(problem).plan(problem.initial, RNG).motion
    assert motion is not None
    result = world(problem).rollout(problem.initial, motion)
    assert result.valid, [str(v) for v in result.violations]
    assert result.moved == ("target",)


def test_a_blocked_retrieval_does_not() -> None:
    problem = one_blocker().problem
    motion = StraightRetrieval(problem).plan(problem.initial, RNG, ignore_movables=True).motion
    assert motion is not None
    result = world(problem).rollout(problem.initial, motion)
    assert [v.constraint for v in result.violations] == ["contact"]


@pytest.mark.parametrize("make", [one_blocker, two_blockers])
def test_pushes_clear_the_way(make: Callable[[], TinyScene]) -> None:
    scene = make()
    problem, model = scene.problem, world(scene.problem)
    pushes, retrieval = StraightPush(problem), StraightRetrieval(problem)
    region, state = region_of(problem), problem.initial
    for name in scene.blockers:
        request = ActionRequest(name, None, region)
        action = next(iter(pushes.propose(state, request, RNG, Statistics())))
        result = model.rollout(state, action.motion)
        assert result.valid, [str(v) for v in result.violations]
        assert result.moved == (name,)
        reached = result.final_state.object_poses[problem.scene.index(name), :2]
        np.testing.assert_allclose(reached, action.path[-1], atol=1e-6)
        state = result.final_state
    motion = retrieval.plan(state, RNG).motion
    assert motion is not None
    assert model.rollout(state, motion).valid


def test_a_push_follows_the_path_to_its_end() -> None:
    problem = one_blocker().problem
    path = np.array([[0.25, 0.0], [0.2, 0.1], [0.25, 0.2]])
    request = ActionRequest("a", path, region_of(problem))
    (action,) = StraightPush(problem).propose(problem.initial, request, RNG, Statistics())
    result = world(problem).rollout(problem.initial, action.motion)
    assert result.moved == ("a",)
    reached = result.final_state.object_poses[problem.scene.index("a"), :2]
    assert np.linalg.norm(reached - path[-1]) < 1e-3


def test_a_path_without_length_is_counted_as_a_failure() -> None:
    problem = one_blocker().problem
    statistics = Statistics()
    request = ActionRequest("a", np.array([[0.25, 0.0]]), region_of(problem))
    assert list(StraightPush(problem).propose(problem.initial, request, RNG, statistics)) == []
    assert statistics.causes == {"a/push/too_short": 1}


def test_an_avoided_grasp_is_not_used() -> None:
    problem = clear_scene().problem
    found = StraightRetrieval(problem).plan(problem.initial, RNG, avoid={0})
    assert found.motion is None
    assert found.causes == {"avoided": 1}
