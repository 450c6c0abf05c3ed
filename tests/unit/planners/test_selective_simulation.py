"""Selective Simulation on tiny scenes: what becomes relevant, and what is simulated."""

from dataclasses import replace

import numpy as np
import pytest
from mamo_planners.baselines.options import SelectiveSimulationOptions
from mamo_planners.baselines.selective_planning import Planned, SelectivePlanning
from mamo_planners.baselines.selective_simulation import _pieces, reduced_problem
from mamo_planners.reaching.goals import Goal, Goals
from mamo_planners.reaching.scenery import look_at

from mamo_core.testing.scenes import (
    clear_scene,
    one_blocker,
    reach_between_corners,
    reach_by_pushing,
    reach_past,
    reach_past_a_corner,
    reach_without_room,
)
from mamo_core.types.scene import Mobility
from mamo_core.types.solution import Budget, SolutionStatus, Statistics
from mamo_core.verify import VerifyReport

STEPS = {"large_step_deg": 4.0}
"""Primitives of 7 cm, so that searches among simulations are short."""


@pytest.fixture
def solved(reaching):
    """The solution for a scene, and the world it was found in."""

    def solve(scene, seed=0, seconds=float("inf"), **options):
        world = reaching(scene.problem)
        return world.solve(world.selective(**options), seed, seconds), world

    return solve


def movables(engine):
    objects = engine.problem.scene.objects
    return tuple(o.name for o in objects if o.mobility is Mobility.MOVABLE)


def phases(world):
    """The movables that each planning phase simulated; the first engine tracks."""
    return [movables(engine) for engine in world.engines[1:]]


def test_the_reduced_problem():
    problem = reach_past_a_corner().problem
    reduced = reduced_problem(problem, ("b",))
    assert [o.name for o in reduced.scene.objects] == ["b", "w", "target"]
    kept = [problem.scene.index(name) for name in ("b", "w", "target")]
    assert np.array_equal(reduced.initial.object_poses, problem.initial.object_poses[kept])
    assert np.array_equal(reduced.initial.joint_positions, problem.initial.joint_positions)
    assert reduced.task is problem.task
    assert len(problem.scene.objects) == 4


@pytest.mark.parametrize("beta", [None, 0.5])
@pytest.mark.parametrize(
    "scene", [reach_past(clear_scene()), reach_past(one_blocker()), reach_by_pushing()]
)
def test_what_nobody_complains_about_stays_irrelevant(solved, scene, beta):
    solution, world = solved(scene, beta=beta)
    assert solution.status is SolutionStatus.SOLVED
    assert phases(world) == [()]
    assert world.engines[1].motions == []
    assert len(world.engines[0].motions) == 2  # the hand opens, and the rest is tracked
    report = world.verified(solution.plan)
    assert report.ok, report.failures


@pytest.mark.parametrize("beta", [None, 0.5])
def test_who_is_to_blame_becomes_relevant(solved, beta):
    solution, world = solved(reach_past_a_corner(), beta=beta, **STEPS)
    assert solution.status is SolutionStatus.SOLVED
    assert phases(world) == [(), ("a",)]
    assert solution.statistics.counts["planning_phases"] == 2
    assert solution.statistics.causes == {"a/reach/contact": 1}
    assert world.engines[2].motions, "the second phase simulates"
    report = world.verified(solution.plan)
    assert report.ok, report.failures


def test_one_after_the_other(solved):
    solution, world = solved(reach_between_corners(), large_step_deg=3.0)
    assert phases(world) == [(), ("a",), ("a", "b")]
    assert solution.status is SolutionStatus.SOLVED
    report = world.verified(solution.plan)
    assert report.ok, report.failures


def test_at_the_limit_of_expansions_a_phase_ends(solved):
    solution, world = solved(reach_past_a_corner(), expansions=12, **STEPS)
    assert phases(world) == [(), ("a",)]
    assert solution.plan is None
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    assert solution.reason == "no path past relevant objects"


@pytest.mark.parametrize("beta", [None, 0.5])
def test_no_plan_breaks_a_constraint(solved, beta):
    solution, world = solved(reach_without_room(), beta=beta, expansions=60)
    assert solution.plan is None
    assert phases(world) == [(), ("a",)]


def test_only_what_touches_relevant_objects_is_simulated(solved):
    """Each motion of the second phase is one primitive, or the last straight one, near the box."""
    _, world = solved(reach_past_a_corner(), **STEPS)
    step = np.radians(4.0)
    for motion in world.engines[2].motions:
        (segment,) = motion.segments
        begin, end = segment.trajectory.positions[[0, -1]]
        to_goal = np.allclose(end, [0.35, 0.0, 0.05, 0.0])
        assert to_goal or np.abs(end - begin).sum() == pytest.approx(step)
        assert np.linalg.norm(begin[:2] - (0.2, 0.045)) < 0.25


def test_soft_duplicates_save_simulations(solved):
    simulated = {}
    for beta in (None, 0.5):
        solution, world = solved(reach_past_a_corner(), beta=beta, **STEPS)
        simulated[beta] = len(world.engines[2].motions)
        assert (solution.statistics.counts["soft_duplicates"] > 0) is (beta is not None)
    assert 0 < simulated[0.5] < simulated[None]


def test_the_straight_motion_to_the_goal_is_put_off_too(solved):
    options = {"beta": 0.5, "snap_distance": 0.3, "expansions": 60, **STEPS}
    solution, world = solved(reach_without_room(), **options)
    goal = [0.35, 0.0, 0.05, 0.0]
    to_goal = [m for m in world.engines[2].motions if np.allclose(m.end, goal)]
    assert solution.statistics.counts["soft_duplicates"] > 1
    assert len(to_goal) == 1


def test_all_simulated_steps_are_counted(solved, reaching):
    solution, world = solved(reach_past_a_corner(), beta=0.5, **STEPS)
    counts = solution.statistics.counts
    assert counts["rollouts"] == sum(len(engine.motions) for engine in world.engines)
    tracked = world.engines[0]
    alone = sum(
        tracked.rollout(world.problem.initial, motion).steps for motion in tuple(tracked.motions)
    )
    assert counts["steps"] > alone


def planned(world, refuted):
    """What a phase plans in which all movables are relevant."""
    parts, options = world.parts, SelectiveSimulationOptions(**STEPS)
    draw = np.random.default_rng(0)
    goals = Goals(parts.problem, parts.arm, parts.kinematics, parts.collision, draw)
    scenery = look_at(parts, goals, options)
    names = movables(world.engines[0])
    limits = Statistics(), Budget(float("inf"))
    phase = SelectivePlanning(parts, world.problem, names, list(refuted), scenery, options, *limits)
    return phase.solve(draw)


def test_an_edge_that_was_refuted_is_not_planned_again(reaching):
    world = reaching(reach_past_a_corner().problem)
    first = planned(world, [])
    refuted = first.path[1:3]
    again = planned(world, [refuted])
    edges = [again.path[i : i + 2] for i in range(len(again.path) - 1)]
    assert len(edges) > 2
    assert not any(np.array_equal(edge, refuted) for edge in edges)


def test_pieces_are_what_was_simulated_and_the_rest_between():
    path = np.arange(12.0).reshape(6, 2)
    simulated = np.array([False, False, True, True, False])
    pieces = _pieces(Planned(path, Goal(path[-1]), simulated))
    assert [piece[:, 0].tolist() for piece in pieces] == [[0, 2, 4], [4, 6], [6, 8], [8, 10]]


def stalling_at(engine, name):
    """The arm does not get through where it touches the object, and nothing else is wrong."""
    rollout = engine.rollout

    def stalled(state, motion, **settings):
        result = rollout(state, motion, **settings)
        touches = ("robot", name) in result.contacts
        return replace(result, violations=(), moved=(), stalled=True) if touches else result

    return stalled


def test_what_an_arm_that_stalled_touched_is_to_blame(reaching):
    world = reaching(reach_by_pushing().problem)
    engine = world.engines[0]
    engine.rollout = stalling_at(engine, "a")
    world.solve(world.selective(expansions=30, **STEPS))
    assert phases(world)[:2] == [(), ("a",)]


def test_where_nobody_is_to_blame_the_last_edge_is_not_taken_again(reaching):
    refused = []

    def refuse(plan):
        refused.append(plan.retrieval.segments[-1].trajectory.positions[-2:].tobytes())
        return VerifyReport(("no",), None)

    world = reaching(reach_past(clear_scene()).problem, verifier=refuse)
    solution = world.solve(world.selective(expansions=30))
    assert solution.plan is None
    assert solution.reason == "no path past relevant objects"
    assert len(set(refused)) > 2


def test_where_nothing_is_broken_who_was_moved_is_to_blame(reaching):
    refuse = lambda plan: VerifyReport(("no",), None)  # noqa: E731
    world = reaching(reach_by_pushing().problem, verifier=refuse)
    world.solve(world.selective(expansions=30))
    assert phases(world)[:2] == [(), ("a",)]


def test_no_budget(solved):
    solution, world = solved(reach_past_a_corner(), seconds=0.0)
    assert solution.reason == "no plan within the budget"
    assert phases(world) == []


def test_same_seed_same_plan(solved):
    paths = [
        np.vstack([s.trajectory.positions for s in solution.plan.retrieval.segments])
        for solution, _ in (solved(reach_past_a_corner(), seed=1, **STEPS) for _ in range(2))
    ]
    assert np.array_equal(*paths)
