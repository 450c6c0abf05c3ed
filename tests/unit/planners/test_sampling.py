"""KPIECE and RRT with a fake engine: valid plans, repeatable, limited by counted motions."""

import gc
import weakref
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from mamo_planners.baselines.sampling.components import components
from mamo_planners.baselines.sampling.growth import strided
from mamo_planners.reaching.stand import ReachingParts

from mamo_core.constraints.standard import ContactConstraint
from mamo_core.interfaces.collision_checker import CollisionChecker, CollisionWorld
from mamo_core.testing.gantry import GantryKinematics
from mamo_core.testing.gantry_arm import gantry_arm
from mamo_core.testing.quasi_static import QuasiStaticModel, QuasiStaticOptions
from mamo_core.testing.scenes import clear_scene, one_blocker, walled_in
from mamo_core.types.problem import Task
from mamo_core.types.scene import Mobility
from mamo_core.types.solution import Budget, SolutionStatus
from mamo_core.verify import VerifyReport, check_form, check_trajectories
from mamo_core.verify_task import check_reached

KINDS = {
    "k1": ("kpiece", {"variant": "k1"}),
    "k2": ("kpiece", {"variant": "k2"}),
    "k3": ("k3", {}),
    "rrt": ("rrt", {}),
}
NAMES = sorted(KINDS)
OF_OMPL = [name for name in NAMES if name != "k3"]
COARSE = QuasiStaticOptions(dt=0.05)
REACH = 0.06
"""How far the fake arm and an object are apart when they may touch, m."""


class Discs(CollisionWorld):
    """The tool is a disc, objects are as wide as they are; the floor is no obstacle."""

    def __init__(self, places):
        self.places = np.asarray(places).reshape(-1, 2)

    def free(self, configurations):
        apart = np.linalg.norm(configurations[:, None, :2] - self.places[None], axis=2)
        return (apart > REACH + 0.03).all(axis=1)

    def edges_free(self, starts, ends):
        ways = starts[:, None] + np.linspace(0, 1, 100)[None, :, None] * (ends - starts)[:, None]
        return np.array([self.free(way).all() for way in ways])


class DiscChecker(CollisionChecker):
    def __init__(self, problem):
        self.names = [item.name for item in problem.scene.objects]

    def world(self, object_poses, *, opening, ignore=(), held=None, margin=0.0):
        return Discs(
            [p[:2] for n, p in zip(self.names, object_poses, strict=True) if n not in ignore]
        )


class Recorder(QuasiStaticModel):
    """Counts rollouts, and breaks at one of them if asked to."""

    rollouts, breaks_at, seen = 0, None, ()

    def rollout(self, *arguments, **options):
        self.rollouts += 1
        if self.rollouts == self.breaks_at:
            raise ZeroDivisionError("the engine broke")
        result = super().rollout(*arguments, **options)
        self.seen = (*self.seen, result)
        return result


@pytest.fixture(scope="module")
def arm():
    return replace(
        gantry_arm(),
        lower=np.array([-0.3, -0.3, 0.04, -0.5]),
        upper=np.array([0.5, 0.3, 0.06, 0.5]),
    )


@pytest.fixture
def parts(arm):
    def make(scene):
        problem = replace(scene.problem, task=Task.REACH)
        kinematics = GantryKinematics(arm.lower, arm.upper)
        model = Recorder(problem, kinematics.forward, [ContactConstraint(problem)], COARSE)
        return ReachingParts(
            problem,
            arm,
            kinematics,
            DiscChecker(problem),
            SimpleNamespace(),
            model,
            partial(verified, problem, arm),
        )

    return make


def verified(problem, arm, plan):
    """Form, the task, and the whole plan in an engine of its own; no meshes."""
    tool = GantryKinematics().forward
    model = QuasiStaticModel(problem, tool, [ContactConstraint(problem)], COARSE)
    rollout = model.rollout(problem.initial, plan.retrieval)
    failures = [
        *check_form(problem, plan),
        *check_trajectories(problem, plan, arm),
        *(str(violation) for violation in rollout.violations),
        *check_reached(problem, plan.retrieval.segments[-1], arm),
    ]
    return VerifyReport(tuple(failures), rollout)


def without_movables(tiny):
    scene, poses = tiny.problem.scene, tiny.problem.initial.object_poses
    kept = [i for i, o in enumerate(scene.objects) if o.mobility is not Mobility.MOVABLE]
    scene = replace(scene, objects=tuple(scene.objects[i] for i in kept))
    initial = replace(tiny.problem.initial, object_poses=poses[kept])
    return replace(tiny, problem=replace(tiny.problem, scene=scene, initial=initial))


def solve(parts, name, seed=0, **options):
    component, own = KINDS[name]
    found = {c.name: c for c in components(lambda context: parts, frozenset({"reach"}))}[component]
    search = found.build(
        None, found.options(**{"motions": 3000, "goal_bias": 0.2, **own, **options})
    )
    return search.solve(Budget(), np.random.default_rng(seed), lambda text: None)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("scene", [clear_scene, one_blocker])
def test_plans_are_found_and_hold(parts, name, scene):
    made = parts(scene())
    solution = solve(made, name)
    assert solution.status is SolutionStatus.SOLVED, solution.reason
    assert made.verifier(solution.plan).ok
    assert solution.statistics.counts["goals_reached"] >= 1


@pytest.mark.parametrize("name", NAMES)
def test_same_seed_same_plan_whatever_ran_before(parts, name):
    first, other = (solve(parts(one_blocker()), name, seed) for seed in (3, 4))
    solve(parts(clear_scene()), "rrt", seed=9)
    again = solve(parts(one_blocker()), name, seed=3)
    assert first.statistics.counts == again.statistics.counts
    assert first.statistics.counts != other.statistics.counts
    rows = [
        np.vstack([s.trajectory.positions for s in solution.plan.retrieval.segments])
        for solution in (first, again)
    ]
    assert np.array_equal(*rows)


@pytest.mark.parametrize("name", NAMES)
def test_motions_are_limited(parts, name):
    solution = solve(parts(one_blocker()), name, motions=25, goal_bias=0.0)
    assert (solution.status, solution.plan) == (SolutionStatus.BUDGET_EXHAUSTED, None)
    assert solution.reason == "no plan within the limits on work"
    assert solution.statistics.counts["motions"] == 25


def test_actions_of_k3_are_limited(parts):
    """Where nothing is touched no motion is simulated, however long it goes on."""
    solution = solve(parts(without_movables(clear_scene())), "k3", actions=30, goal_bias=0.0)
    assert solution.reason == "no plan within the limits on work"
    assert solution.statistics.counts["actions"] == 30


@pytest.mark.parametrize("name", NAMES)
def test_time_is_limited(parts, name):
    made = parts(walled_in())
    component, own = KINDS[name]
    found = {c.name: c for c in components(lambda context: made, frozenset())}[component]
    search = found.build(None, found.options(**own))
    solution = search.solve(Budget(0.0), np.random.default_rng(0), lambda text: None)
    assert solution.reason == "no plan within the budget"
    assert solution.statistics.counts["motions"] == 0


@pytest.mark.parametrize("name", NAMES)
def test_errors_of_the_engine_arrive(parts, name):
    """They do not get lost in OMPL, and nothing is simulated after."""
    made = parts(one_blocker())
    made.backend.breaks_at = 3
    with pytest.raises(ZeroDivisionError, match="the engine broke"):
        solve(made, name)
    assert made.backend.rollouts == 3
    seen = weakref.ref(made.backend)
    del made
    gc.collect()
    assert seen() is None, "cycles through OMPL's objects are never collected"


@pytest.mark.parametrize("name", NAMES)
def test_what_cannot_be_taken_up(parts, name):
    made = parts(clear_scene())
    poses = made.problem.initial.object_poses.copy()
    poses[-1, 2] = 1.0  # the target is out of reach
    initial = replace(made.problem.initial, object_poses=poses)
    made = replace(made, problem=replace(made.problem, initial=initial))
    solution = solve(made, name)
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    assert solution.reason == "no pre-grasp can be taken up even without movables"


@pytest.mark.parametrize("name", OF_OMPL)
def test_every_action_is_simulated(parts, name):
    made = parts(clear_scene())
    solution = solve(made, name)
    assert all(segment.kind != "transit" for segment in solution.plan.retrieval.segments)
    assert made.backend.rollouts == 1 + solution.statistics.counts["motions"]


def test_k3_simulates_only_what_touches_something(parts):
    made = parts(without_movables(clear_scene()))
    solution = solve(made, "k3")
    # The start, and the whole way once there is a plan.
    assert (solution.statistics.counts["motions"], made.backend.rollouts) == (0, 2)


def test_k3_never_simulates_what_touches_immovables(parts):
    made = parts(walled_in())
    scene = made.problem.scene
    solve(made, "k3", motions=40)
    still = {o.name for o in scene.objects if o.mobility is not Mobility.MOVABLE}
    for result in made.backend.seen:
        assert not any("robot" in pair and still & set(pair) for pair in result.contacts)


def test_strides():
    start, end = np.zeros(2), np.array([1.0, -0.4])
    places = strided(start, end, 0.5)
    np.testing.assert_allclose(places, [[0.5, -0.2], [1.0, -0.4]])
    np.testing.assert_allclose(strided(start, end, 2.0), [end])
    assert strided(start, start, 0.5).shape == (0, 2)


def test_joints_without_limits_turn_half_a_turn(arm):
    loose = replace(arm, lower=np.full(4, -100.0), upper=np.full(4, 100.0), home=np.ones(4))
    low, high = loose.around_home
    np.testing.assert_allclose(high - low, 2 * np.pi)
    np.testing.assert_allclose((high + low) / 2, 1.0)
