"""A plan must hold in worlds close to the problem's, by the verifier's own engine."""

from dataclasses import replace

import numpy as np
import pytest

from mamo_core.interfaces.transition_model import Replay
from mamo_core.robots.exact_collision import ExactChecker
from mamo_core.robots.passage import passes
from mamo_core.types.deviation import NEIGHBOURS
from mamo_core.types.rollout import Violation
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Plan
from mamo_core.verify import verify, verify_replays
from mamo_core.verify_replays import check_replays


def shifted(problem, name, shift):
    """The start with one object elsewhere by ``shift`` (2,) m."""
    poses = np.array(problem.initial.object_poses)
    poses[problem.scene.index(name), :2] += shift
    return SceneState(problem.initial.joint_positions, poses)


@pytest.fixture
def context(planner):
    return planner.context


@pytest.fixture
def elsewhere(problem, context):
    """The post stands where the blocker is pushed: no neighbour, but a world all the same."""
    blocker, post = (
        problem.initial.object_poses[problem.scene.index(name), :2] for name in ("blocker", "post")
    )
    there = shifted(problem, "post", 0.8 * (blocker - post))
    return Replay("with the post in the way", context.backend, there)


def test_the_plan_is_asked_in_its_neighbours_and_at_finer_steps(problem, context):
    replays = context.replays()
    assert len(replays) == NEIGHBOURS + 2
    assert [r.name for r in replays[-2:]] == ["at half steps", "at quarter steps"]
    own = context.backend
    assert all(r.model is own for r in replays[:-2])
    for replay in replays[-2:]:
        assert replay.model is not own
        assert replay.start is problem.initial
    farther = context.replays(problem, extra=3)
    assert len(farther) == NEIGHBOURS + 2 + 3


def test_what_fails_in_a_neighbour_is_refused_by_its_name(problem, context, plan, elsewhere):
    nominal = verify(problem, plan, context.backend, context.robot)
    assert nominal.ok
    own = Replay("as it is", context.backend, problem.initial)
    assert verify_replays(nominal, problem, plan, [own], context.robot) is nominal
    found = verify_replays(nominal, problem, plan, [own, elsewhere], context.robot)
    assert not found.ok
    assert found.kinds == ("replay",)
    (failure,) = found.failures
    assert failure.startswith("in the replay with the post in the way: contact: ")
    assert "post" in failure


class Canned:
    """An engine that answers with one result."""

    def __init__(self, result):
        self.result, self.calls = result, 0

    def rollout(self, state, motion, **settings):
        self.calls += 1
        return self.result


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"lost": "the process died"}, "the process died"),
        ({"stalled": True}, "the arm could not follow its trajectory"),
        ({"violations": (Violation("tilt", "blocker", None, 1.0, 0.5, 0.4),)}, "tilt: blocker at "),
    ],
)
def test_why_it_fails(problem, context, plan, changes, why):
    fine = context.backend.rollout(problem.initial, plan.motions[0])
    engine = Canned(replace(fine, **changes))
    replays = [Replay(name, engine, problem.initial) for name in ("one", "two")]
    checker = ExactChecker(problem.scene, context.robot)
    (text,) = check_replays(plan.motions, replays, checker, problem.scene, context.robot)
    assert text.startswith(f"in the replay one: {why}")
    assert engine.calls == 1


def test_an_arm_passes_what_it_does_not_touch(problem, context, plan):
    checker = ExactChecker(problem.scene, context.robot)
    motion = plan.retrieval
    reach, poses = motion.parts().before, plan_state(problem, context, plan).object_poses

    def free(state):
        return passes(checker, problem.scene, context.robot, reach, state, motion.opening)

    after = SceneState(problem.home, poses)
    assert reach
    assert free(after)
    # Before the push the blocker is still where the hand passes.
    assert not free(problem.initial)


def test_what_is_in_the_hand_passes_too(problem, context, plan):
    """The same way out, and a post where only the target comes by."""
    checker = ExactChecker(problem.scene, context.robot)
    state = plan_state(problem, context, plan)
    _, touching, after = plan.retrieval.parts()
    held = context.backend.rollout(state.with_joints(touching.start), touching).final_state
    opening = touching.segments[-1].opening
    scene, robot = problem.scene, context.robot
    assert after
    assert all(segment.held == "target" for segment in after)
    assert passes(checker, scene, robot, after, held, opening)
    poses = np.array(held.object_poses)
    poses[scene.index("post")] = poses[scene.target_index]
    blocked = SceneState(held.joint_positions, poses)
    assert not passes(checker, scene, robot, after, blocked, opening)


def plan_state(problem, context, plan):
    """Once everything is rearranged."""
    state = problem.initial
    for action in plan.actions:
        end = context.backend.rollout(state, action.motion).final_state
        state = end.with_joints(action.motion.end)
    return state


def test_a_recipes_steps_are_not_the_verifiers(problem, compose_for, plan):
    """What replays, and its finer steps, are of 4 ms; only the search has 10 ms."""
    long = compose_for(problem, "backend={name: mujoco, time_step: 0.01}")
    own = verify(problem, plan, compose_for(problem).context.backend, long.context.robot)
    coarse = verify(problem, plan, long.context.backend, long.context.robot)
    report = long.context.verifier(plan, replays=False, friction=False)
    assert report.rollout.steps == own.rollout.steps
    assert coarse.rollout.steps < 0.6 * own.rollout.steps
    near, *_, half, _ = long.context.replays()
    first = plan.motions[0]
    steps = [r.model.rollout(problem.initial, first).steps for r in (near, half)]
    assert steps[1] == pytest.approx(2 * steps[0], rel=0.02)


def test_what_a_search_executed_with_other_steps_is_not_trusted(problem, compose_for, plan):
    """A search that claims an execution with long steps does not spare the replay."""
    long = compose_for(problem, "backend={name: mujoco, time_step: 0.01}").context
    state, results = problem.initial, []
    for motion in plan.motions:
        results.append(replace(long.backend.rollout(state, motion), violations=(), stalled=False))
        state = results[-1].final_state.with_joints(motion.end)
    report = long.verifier(plan, executed=results, replays=False, friction=False)
    assert report.rollout.steps > 1.5 * sum(result.steps for result in results)


def test_a_plan_without_actions_is_refused(context, plan):
    report = context.verifier(Plan((), plan.retrieval))
    assert not report.ok
