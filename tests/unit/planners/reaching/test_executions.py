"""Segments one after the other are one execution; and how a retrieval goes on from a pre-grasp."""

from dataclasses import replace

import numpy as np
import pytest
from mamo_planners.grasp_candidates import Candidate
from mamo_planners.reaching.goals import Goal
from mamo_planners.reaching.motions import Motions
from mamo_planners.reaching.options import MotionOptions
from mamo_planners.reaching.retrieving import carried_home
from mamo_planners.reaching.stand import Executions

from mamo_core.interfaces.collision_checker import HeldObject
from mamo_core.testing.scenes import HOME, OPENING, clear_scene, one_blocker, reach_past, walled_in
from mamo_core.types.geometry import matrix_from_pose, tool_matrix
from mamo_core.types.motion import Motion, SegmentKind
from mamo_core.types.solution import Budget, Statistics
from mamo_core.verify import VerifyReport

PREGRASP = np.array([0.35, 0.0, 0.05, 0.0])
BESIDE = np.array([0.20, -0.10, 0.05, 0.0])
INTO_IT = np.array([0.25, 0.04, 0.05, 0.0])
"""A finger goes to where the box in the middle stands."""


class Bench:
    """Executions of a tiny scene, what they count, and how motions are made."""

    def __init__(self, world):
        self.parts = world.parts
        self.statistics = Statistics()
        self.executions = Executions(self.parts, self.statistics, Budget())
        options = MotionOptions()
        self.motions = Motions(self.parts.arm, self.parts.kinematics, options, OPENING)

    def start(self):
        return self.executions.start(self.motions.opened(HOME))

    def sweep(self, *stations):
        return self.motions.sweep(np.array(stations))


@pytest.fixture
def bench(reaching):
    return Bench(reaching(reach_past(one_blocker()).problem))


def test_segments_in_turn_are_one_continuous_rollout(bench):
    segments = [
        bench.motions.opened(HOME),
        bench.sweep(HOME, BESIDE),
        bench.sweep(BESIDE, [0.25, 0.1, 0.05, 0.3]),
        bench.sweep([0.25, 0.1, 0.05, 0.3], PREGRASP),
    ]
    stand = bench.executions.start(segments[0])
    for segment in segments[1:]:
        stand = bench.executions.after(stand, segment)
    problem, closed = bench.parts.problem, bench.parts.arm.gripper.closed
    whole = bench.parts.backend.rollout(problem.initial, Motion(tuple(segments), closed))
    assert whole.moved == ("a",)
    assert np.array_equal(stand.state.object_poses, whole.final_state.object_poses)
    assert np.array_equal(stand.state.joint_positions, PREGRASP)
    assert stand.segments == tuple(segments)
    assert bench.statistics.counts["steps"] == whole.steps
    assert bench.statistics.counts["rollouts"] == 4


def test_a_stand_is_a_value(bench):
    """To try a segment changes nothing for the next one that is tried from there."""
    stand = bench.executions.after(bench.start(), bench.sweep(HOME, BESIDE))
    push = bench.sweep(BESIDE, [0.25, 0.1, 0.05, 0.0])
    states = [bench.executions.after(stand, push).state for _ in range(2)]
    assert np.array_equal(states[0].object_poses, states[1].object_poses)
    assert not np.array_equal(stand.state.object_poses, states[0].object_poses)


def test_the_path_of_a_stand(bench):
    stand = bench.executions.after(bench.start(), bench.sweep(HOME, BESIDE))
    assert np.array_equal(stand.path[0], HOME)
    assert np.array_equal(stand.path[-1], BESIDE)


def test_an_invalid_segment_gives_none_and_is_counted(reaching):
    bench = Bench(reaching(reach_past(walled_in()).problem))
    assert bench.executions.after(bench.start(), bench.sweep(HOME, INTO_IT)) is None
    assert bench.statistics.causes == {"robot/reach/contact": 1}
    (violation,) = bench.executions.last.violations
    assert {violation.subject, violation.other} == {"robot", "w"}


def test_a_stalled_arm_gives_none_and_is_counted(reaching):
    scene = reach_past(one_blocker()).problem
    heavy = tuple(replace(o, mass=100.0) for o in scene.scene.objects)
    bench = Bench(reaching(replace(scene, scene=replace(scene.scene, objects=heavy))))
    assert bench.executions.after(bench.start(), bench.sweep(HOME, INTO_IT)) is None
    assert bench.statistics.causes == {"robot/reach/stalled": 1}


def test_alone_begins_where_the_segment_does_with_objects_at_first(bench):
    """Whatever was executed before."""
    pushes = bench.sweep(BESIDE, [0.25, 0.1, 0.05, 0.0])
    bench.executions.after(bench.executions.after(bench.start(), bench.sweep(HOME, BESIDE)), pushes)
    assert bench.executions.alone(pushes)
    assert "a" in bench.executions.last.moved
    # Alone the hand is open all the time.
    (segment,) = bench.parts.backend.motions[-1].segments
    assert bench.parts.backend.motions[-1].opening == segment.opening == OPENING


def test_what_the_verifier_refuses_is_no_plan(reaching):
    world = reaching(reach_past(one_blocker()).problem)
    bench = Bench(world)
    stand = bench.executions.after(bench.start(), bench.sweep(HOME, BESIDE))
    assert bench.executions.finished(stand, Goal(BESIDE), np.random.default_rng(0)) is None
    (cause,) = bench.statistics.causes
    assert cause.startswith("plan/verification/the hand does not end, open")
    reached = bench.executions.after(stand, bench.sweep(BESIDE, PREGRASP))
    plan = bench.executions.finished(reached, Goal(PREGRASP), np.random.default_rng(0))
    assert plan.retrieval.segments == reached.segments
    assert plan.actions == ()


WIDTH = 0.06
"""Of the target between the fingers, m."""


def candidate_of(problem):
    grasp_at = PREGRASP + np.array([0.1, 0.0, 0.0, 0.0])
    lifted = grasp_at + np.array([0.0, 0.0, 0.05, 0.0])
    target = problem.scene.target_index
    T_world_target = matrix_from_pose(problem.initial.object_poses[target])
    T_world_tool = tool_matrix(grasp_at[:3], 0.0)
    shape = problem.scene.objects[target].shape
    held = HeldObject.taken("target", shape, T_world_tool, T_world_target)
    reach, lift = np.stack([PREGRASP, grasp_at]), np.stack([grasp_at, lifted])
    return Candidate(0, problem.grasps[0], WIDTH, reach, lift, held)


def carry(world, way):
    problem = world.problem
    return carried_home(
        world.parts,
        problem.initial,
        way,
        candidate_of(problem),
        np.random.default_rng(0),
    )


WAY = np.array([HOME, [0.1, -0.25, 0.05, 0.0], [0.3, -0.2, 0.05, 0.0], PREGRASP])
"""From home to the pre-grasp, beside the box in the middle."""


def test_the_target_is_carried_home_along_a_free_way(reaching):
    world = reaching(one_blocker().problem)
    world.parts.arm_planner.always = True
    reach, close, lift, back = carry(world, WAY)
    assert [s.kind for s in (reach, close, lift, back)] == [
        SegmentKind.REACH,
        SegmentKind.GRIPPER,
        SegmentKind.LIFT,
        SegmentKind.CARRY,
    ]
    assert [s.held for s in (reach, close, lift, back)] == [None, None, "target", "target"]
    assert (close.closes_on, close.opening, back.opening) == ("target", WIDTH, WIDTH)
    assert back.contact_free
    assert back.trajectory.positions[-1] == pytest.approx(HOME)
    assert np.ptp(back.trajectory.positions[:, 1]) == 0.0


def test_else_it_goes_back_the_way_it_came(reaching):
    _, _, lift, back = carry(reaching(one_blocker().problem), WAY)
    assert not back.contact_free
    positions = back.trajectory.positions
    assert positions[0] == pytest.approx(lift.trajectory.positions[-1])
    assert positions[-1] == pytest.approx(HOME)
    for station in WAY:
        # Corners are blended, and rows are a few millimetres apart.
        assert np.abs(positions - station).max(axis=1).min() < 5e-3


def test_at_a_candidate_the_plan_goes_on_until_the_target_is_at_home(reaching):
    problem = clear_scene().problem
    seen = []

    def accept(plan):
        seen.append(plan)
        return VerifyReport((), None)

    bench = Bench(reaching(problem, verifier=accept))
    gone = bench.motions.transit(np.stack([HOME, PREGRASP]))
    stand = bench.executions.after(bench.start(), gone)
    goal = Goal(PREGRASP, candidate_of(problem))
    plan = bench.executions.finished(stand, goal, np.random.default_rng(0))
    assert seen == [plan]
    assert [s.kind for s in plan.retrieval.segments[2:]] == ["reach", "gripper", "lift", "carry"]
    assert plan.retrieval.end == pytest.approx(HOME)
    target = bench.executions.last.final_state.object_poses[problem.scene.target_index]
    assert target[:2] == pytest.approx(HOME[:2], abs=1e-6)


def test_a_retrieval_that_is_stopped_on_its_way_is_no_plan(reaching):
    """The way home is what is blocked here."""
    world = reaching(walled_in().problem, verifier=lambda plan: VerifyReport((), None))
    world.parts.arm_planner.always = True
    bench = Bench(world)
    stand = bench.start()
    for station in WAY[1:]:
        before = stand.path[-1]
        stand = bench.executions.after(stand, bench.motions.transit(np.stack([before, station])))
    goal = Goal(PREGRASP, candidate_of(world.problem))
    assert bench.executions.finished(stand, goal, np.random.default_rng(0)) is None
    assert "w/reach/contact" in bench.statistics.causes
