"""What a search relies on, checked in the real parts of the recipe."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mamo_core.build_context import BuildContext
from mamo_core.compose import compose
from mamo_core.config import load_file
from mamo_core.interfaces.action_generator import ActionGenerator, ActionRequest
from mamo_core.plugins import discover
from mamo_core.problems import load_problem
from mamo_core.recipes import load_recipe
from mamo_core.types.action import RearrangementAction
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Statistics
from mamo_my_action.action import KIND

FOLDER = Path(__file__).parents[1]
BLOCKER = "blocker"


@pytest.fixture(scope="module")
def context() -> BuildContext:
    """The parts of the recipe, built for the problem beside it."""
    recipe = load_recipe(load_file(FOLDER / "recipe.yaml"))
    return compose(recipe, load_problem(FOLDER / "problem.yaml"), discover()).context


@pytest.fixture(scope="module")
def generator(context: BuildContext) -> ActionGenerator:
    return dict(context.actions)[KIND]


@pytest.fixture(scope="module")
def request_for(context: BuildContext) -> ActionRequest:
    """Bring the blocker 12 cm to the robot's left."""
    state = context.problem.initial
    retrieval = context.part("retrieval")
    motion = retrieval.plan(state, np.random.default_rng(0), ignore_movables=True).motion
    here = state.object_poses[context.problem.scene.index(BLOCKER), :2]
    path = np.stack([here, here + np.array([0.0, 0.12])])
    return ActionRequest(BLOCKER, path, retrieval.swept_region(state, motion))


def proposed(
    context: BuildContext, generator: ActionGenerator, request: ActionRequest, seed: int = 0
) -> list[RearrangementAction]:
    rng = np.random.default_rng(seed)
    return list(generator.propose(context.problem.initial, request, rng, Statistics()))


def test_actions_have_the_form_that_searches_expect(
    context: BuildContext, generator: ActionGenerator, request_for: ActionRequest
) -> None:
    actions = proposed(context, generator, request_for)
    assert actions
    start, robot = context.problem.initial.joint_positions, context.robot
    for action in actions:
        assert (action.kind, action.object_name) == (KIND, BLOCKER)
        assert np.allclose(action.motion.start, start)
        for segment in action.motion.segments:
            positions = segment.trajectory.positions
            assert (positions >= robot.lower - 1e-6).all()
            assert (positions <= robot.upper + 1e-6).all()


def test_the_object_moves_where_it_should(
    context: BuildContext, generator: ActionGenerator, request_for: ActionRequest
) -> None:
    backend, start = context.part("backend"), context.problem.initial
    place = context.problem.scene.index(BLOCKER)
    results = [
        backend.rollout(start, action.motion)
        for action in proposed(context, generator, request_for)
    ]
    valid = [result for result in results if result.valid]
    assert valid
    shifts = [r.final_state.object_poses[place, 1] - start.object_poses[place, 1] for r in valid]
    assert max(shifts) > 0.05


def test_the_same_seed_gives_the_same_actions(
    context: BuildContext, generator: ActionGenerator, request_for: ActionRequest
) -> None:
    first, second = (proposed(context, generator, request_for, seed=3) for _ in range(2))
    assert len(first) == len(second)
    for one, other in zip(first, second, strict=True):
        for a, b in zip(one.motion.segments, other.motion.segments, strict=True):
            assert np.array_equal(a.trajectory.positions, b.trajectory.positions)


def test_what_cannot_be_done_is_counted(
    context: BuildContext, generator: ActionGenerator, request_for: ActionRequest
) -> None:
    """An object that stands 5 m away is out of reach."""
    poses = np.array(context.problem.initial.object_poses)
    poses[context.problem.scene.index(BLOCKER), :2] = 5.0
    state = SceneState(context.problem.initial.joint_positions, poses)
    statistics, rng = Statistics(), np.random.default_rng(0)
    request = ActionRequest(BLOCKER, None, request_for.region)
    assert list(generator.propose(state, request, rng, statistics)) == []
    assert set(statistics.causes) == {f"{BLOCKER}/{KIND}/no_ik"}
