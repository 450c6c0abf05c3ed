"""SPAMP on tiny scenes: what it simulates, when, and what it never returns."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from mamo_core.interfaces.arm_planner import ArmPlan, ArmPlanner, ArmPlanStatus
from mamo_core.plan_file import PlanDocument, plan_text
from mamo_core.testing.gantry_arm import gantry_arm
from mamo_core.testing.scenes import (
    HOME,
    clear_scene,
    one_blocker,
    reach_by_pushing,
    reach_past,
    reach_without_room,
    walled_in,
)
from mamo_core.types.motion import SegmentKind
from mamo_core.types.solution import SolutionStatus
from mamo_core.verify import VerifyReport

NAIVE = {"subgoals": 0, "snap": False, "rounds": 1}
PHASE1 = {"simulate_samples": False, "samples": 3, "t_sim": 0.0, "snap": False, "rounds": 1}
SCENES = {
    "clear": reach_past(clear_scene()),
    "one_blocker": reach_past(one_blocker()),
    "walled_in": reach_past(walled_in()),
    "by_pushing": reach_by_pushing(),
}
VARIANTS = {"spamp": {}, "naive": {**NAIVE, "beta": None}, "naive_dd": NAIVE, "phase1": PHASE1}

FEW = {"large_step_deg": np.degrees(0.1), "delta": 0.3}
"""Large steps in a small space: a search comes to the end of all states."""


class NoWay(ArmPlanner):
    """Finds none."""

    def plan(self, start, goals, world, rng, *, max_checks=None):
        return ArmPlan(ArmPlanStatus.EXHAUSTED, None, 0, 1)


def small_arm():
    lower, upper = np.array([-0.2, -0.2, 0.05, 0.0]), np.array([0.5, 0.2, 0.25, 0.0])
    return replace(gantry_arm(), lower=lower, upper=upper)


@pytest.fixture
def solved(reaching):
    """The solution for a scene, and the world it was found in."""

    def solve(scene, seed=0, seconds=float("inf"), **options):
        world = reaching(scene.problem)
        return world.solve(world.spamp(**options), seed, seconds), world

    return solve


def kinds(solution):
    return [segment.kind for segment in solution.plan.retrieval.segments]


@pytest.mark.parametrize("variant", sorted(VARIANTS))
@pytest.mark.parametrize("name", sorted(SCENES))
def test_every_plan_holds(solved, name, variant):
    solution, world = solved(SCENES[name], expansions=300, **VARIANTS[variant])
    assert solution.status is SolutionStatus.SOLVED, solution.reason
    report = world.verified(solution.plan)
    assert report.ok, report.failures
    assert report.rollout.final_state.joint_positions == pytest.approx(
        [0.35, 0.0, 0.05, 0.0], abs=1e-9
    )


@pytest.mark.parametrize("name", ["clear", "walled_in"])
@pytest.mark.parametrize("variant", sorted(VARIANTS))
def test_where_nothing_need_be_pushed_nothing_is_simulated(solved, name, variant):
    solution, world = solved(SCENES[name], expansions=300, **VARIANTS[variant])
    assert sum(len(engine.motions) for engine in world.engines) == 0
    assert solution.statistics.counts["simulated_primitives"] == 0
    assert kinds(solution) == [SegmentKind.GRIPPER, SegmentKind.TRANSIT]
    assert all(segment.contact_free for segment in solution.plan.retrieval.segments)


@pytest.mark.parametrize("variant", sorted(VARIANTS))
def test_only_the_last_motion_pushes(solved, variant):
    solution, world = solved(reach_by_pushing(), **VARIANTS[variant])
    *before, last = solution.plan.retrieval.segments
    assert last.kind is SegmentKind.SWEEP
    assert all(segment.contact_free for segment in before)
    assert not last.contact_free
    rollout = world.verified(solution.plan).rollout
    assert rollout.moved == ("a",)
    assert rollout.contacts == {("robot", "a")}


def test_only_primitives_are_simulated(solved):
    _, world = solved(reach_by_pushing())
    for motion in world.engines[0].motions:
        (segment,) = motion.segments
        assert segment.kind is SegmentKind.SWEEP
        assert segment.trajectory.positions[-1] == pytest.approx([0.35, 0.0, 0.05, 0.0])


@pytest.mark.parametrize("variant", sorted(VARIANTS))
def test_no_plan_breaks_a_constraint(solved, variant):
    options = {**VARIANTS[variant], "expansions": 120, "rounds": 1}
    solution, world = solved(reach_without_room(), **options)
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    assert solution.plan is None
    assert solution.reason == "nothing is left to try"
    counts, causes = solution.statistics.counts, solution.statistics.causes
    assert counts["simulated_primitives"] == len(world.engines[0].motions) > 0
    assert causes["a/reach/contact"] > 0
    assert set(causes) <= {"a/reach/contact", "a/reach/speed", "e/reach/speed"}


def test_soft_duplicates_are_put_off_with_beta_only(solved):
    simulated = {}
    for beta in (None, 0.5):
        solution, _ = solved(reach_without_room(), **NAIVE, beta=beta, expansions=250)
        counts = solution.statistics.counts
        simulated[beta] = counts["simulated_primitives"]
        assert (counts["soft_duplicates"] > 0) is (beta is not None)
    assert 0 < simulated[0.5] < simulated[None]


def test_naive_simulates_every_primitive_that_may_push(solved):
    """One for each state that it expands within delta, but for the last ones' goals' motions."""
    solution, world = solved(reach_without_room(), **NAIVE, beta=None, expansions=150)
    starts = [motion.start for motion in world.engines[0].motions]
    assert len(starts) == solution.statistics.counts["simulated_primitives"]
    assert len({tuple(start) for start in starts}) == len(starts) > 3


def test_put_off_states_are_simulated_in_the_end(reaching):
    """Soft duplicates are put off, not given up: with nothing else to expand they are next."""
    world = reaching(reach_without_room().problem, arm=small_arm())
    found = [
        world.solve(world.spamp(**NAIVE, **FEW, beta=beta, expansions=5000)).statistics.counts
        for beta in (None, 9.0)
    ]
    assert found[1]["soft_duplicates"] > 0
    assert found[0]["expansions"] + found[1]["soft_duplicates"] == found[1]["expansions"] < 5000
    assert found[0]["simulated_primitives"] == found[1]["simulated_primitives"] > 1


@pytest.mark.parametrize("seed", range(3))
def test_a_subgoal_that_failed_is_put_off_too(solved, seed):
    """Its queue has brought the search to where it begins, which is 0 primitives away."""
    solution, _ = solved(reach_without_room(), seed, rounds=1, expansions=100)
    counts = solution.statistics.counts
    assert counts["soft_duplicates"] > 0
    assert counts["simulated_primitives"] == counts["drawn_primitives"] == 8


class TestSimulationsOfTheSearch:
    """Between valid subgoals and ``t_sim``: a wall keeps the search from its valid subgoals."""

    @pytest.fixture
    def counts(self, reaching):
        def solve(valid, t_sim, expansions=35):
            world = reaching(reach_without_room().problem, arm=small_arm())
            options = {"rounds": 1, "beta": None, "snap": False, **FEW}
            search = world.spamp(t_sim=t_sim, expansions=expansions, **options)
            if valid:
                self._believe_in_what_is_drawn(world)
            return world.solve(search).statistics.counts

        return solve

    @staticmethod
    def _believe_in_what_is_drawn(world):
        """The first eight rollouts are said to be valid; then the truth is told."""
        rollout, rest = world.engines[0].rollout, itertools.count()

        def generous(state, motion, **settings):
            result = rollout(state, motion, **settings)
            if next(rest) >= 8:
                return result
            return replace(result, violations=(), stalled=False)

        world.engines[0].rollout = generous

    def test_with_a_valid_subgoal_none_before_t_sim(self, counts):
        found = counts(valid=True, t_sim=1e6)
        assert found["simulated_primitives"] == found["drawn_primitives"] == 8
        assert found["expansions"] == 35

    def test_but_all_before_it_gives_up(self, counts):
        found = counts(valid=True, t_sim=1e6, expansions=1000)
        assert found["expansions"] < 1000
        assert found["simulated_primitives"] > 8

    def test_with_a_valid_subgoal_some_after_t_sim(self, counts):
        assert counts(valid=True, t_sim=0.0)["simulated_primitives"] > 8

    def test_without_one_from_the_beginning(self, counts):
        assert counts(valid=False, t_sim=1e6)["simulated_primitives"] > 8


def test_no_more_is_drawn_than_enough(solved):
    drawn = [
        solved(reach_by_pushing(), enough=enough)[0].statistics.counts["drawn_primitives"]
        for enough in (1, 2, 8)
    ]
    assert drawn[0] < drawn[1] < drawn[2] == 8


def test_nothing_is_drawn_close_to_what_was_out_of_reach(reaching):
    drawn = []
    for beta in (None, 9.0):
        world = reaching(reach_by_pushing().problem, arm_planner=NoWay())
        search = world.spamp(beta=beta, connect=True, snap=False, expansions=1, rounds=2)
        drawn.append(world.solve(search).statistics.counts["drawn_primitives"])
    assert drawn == [16, 8]


def document(solution, world):
    return plan_text(PlanDocument(world.problem, solution.plan, {"name": "spamp"}, 0))


@pytest.mark.parametrize("name", ["one_blocker", "by_pushing"])
def test_same_seed_same_bytes(solved, name):
    texts = [document(*solved(SCENES[name], seed=3)) for _ in range(2)]
    assert texts[0] == texts[1]
    assert document(*solved(SCENES[name], seed=4)) != texts[0]


def test_no_budget(solved):
    solution, world = solved(reach_without_room(), seconds=0.0)
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    assert solution.reason == "no plan within the budget"
    assert solution.statistics.counts["rounds"] == 1
    assert solution.statistics.counts["expansions"] == 0
    assert len(world.engines[0].motions) <= 1


def test_other_processes_count_for_the_budget(reaching):
    world = reaching(reach_without_room().problem)
    told = []

    def far_away(state, motion, **settings):
        told.append(motion)
        result = type(world.engines[0]).rollout(world.engines[0], state, motion, **settings)
        return replace(result, outside_cpu=1000.0)

    world.engines[0].rollout = far_away
    solution = world.solve(world.spamp(), seconds=2500.0)
    assert solution.reason == "no plan within the budget"
    assert len(told) == 3


def test_what_the_verifier_refuses_is_not_returned(reaching):
    asked = []

    def refuse(plan):
        asked.append(plan)
        return VerifyReport(("no",), None)

    world = reaching(reach_by_pushing().problem, verifier=refuse)
    solution = world.solve(world.spamp(rounds=2, expansions=20))
    assert solution.plan is None
    assert len(asked) > 1
    assert solution.statistics.causes["plan/verification/no"] == len(asked)


def test_rounds_follow_luby(reaching):
    world = reaching(reach_without_room().problem)
    expansions = []
    for rounds in (1, 2, 3):
        solution = world.solve(world.spamp(rounds=rounds, expansions=15))
        assert solution.statistics.counts["rounds"] == rounds
        expansions.append(solution.statistics.counts["expansions"])
    assert expansions == [15, 30, 60]


def test_without_a_goal(reaching):
    problem = reach_past(clear_scene()).problem
    far = replace(problem, grasps=(replace(problem.grasps[0], approach=9.0),))
    world = reaching(far)
    solution = world.solve(world.spamp())
    assert solution.reason == "no pre-grasp can be taken up even without movables"
    assert solution.statistics.counts["expansions"] == 0


def test_no_segment_is_empty(reaching):
    """Not even where the last motion begins at home."""
    problem = reach_by_pushing().problem
    near = np.array([0.35, -0.1, 0.05, 0.0])
    state = replace(problem.initial, joint_positions=near)
    world = reaching(replace(problem, initial=state, home=near))
    solution = world.solve(world.spamp(**NAIVE))
    assert solution.statistics.counts["expansions"] == 1
    assert all(s.trajectory.duration > 0.0 for s in solution.plan.retrieval.segments)
    assert not np.array_equal(solution.plan.retrieval.end, HOME)


class TestBeyondTheThesis:
    def test_the_arm_planner_leads_to_valid_subgoals(self, solved):
        solution, _ = solved(SCENES["by_pushing"], connect=True)
        assert solution.plan is not None
        assert solution.statistics.seconds["arm_planning"] > 0.0
        assert not solution.statistics.counts["expansions"]

    def test_without_a_way_the_search_goes_on(self, solved):
        solution, _ = solved(SCENES["by_pushing"], connect=False)
        assert solution.plan is not None
        assert "arm_planning" not in solution.statistics.seconds
        assert solution.statistics.counts["expansions"]

    def test_delta_grows_with_the_rounds_up_to_the_widest(self, solved, monkeypatch):
        seen = []

        def none(run, via):
            seen.append(run.primitives.delta)
            return []

        monkeypatch.setattr("mamo_planners.reaching.spamp.Run._subgoals", none)
        solved(reach_without_room(), rounds=4, expansions=1, delta=0.2, growth=0.5, widest=0.35)
        assert seen == pytest.approx([0.2, 0.3, 0.35, 0.35])

    def test_primitives_bend_from_the_second_round_on(self, solved):
        bent = {}
        for via in (0.0, 1.0):
            scene = reach_without_room()
            _, world = solved(scene, rounds=2, expansions=1, samples=16, via=via)
            (engine,) = world.engines
            bent[via] = any(turns(m.segments[-1].trajectory.positions) for m in engine.motions)
        assert bent == {0.0: False, 1.0: True}


def turns(positions):
    """Whether the way (k, dof) is not one straight line."""
    ways = np.diff(positions, axis=0)
    ways = ways[np.linalg.norm(ways, axis=1) > 1e-9]
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    return bool((np.abs(ways - ways[0]) > 1e-6).any())


def test_a_subgoal_that_does_not_hold_keeps_its_queue(reaching):
    """States that are put off are put off in the queue they came from, whoever it belongs to."""
    refuse = lambda plan: VerifyReport(("no",), None)  # noqa: E731
    world = reaching(reach_by_pushing().problem, verifier=refuse)
    solution = world.solve(world.spamp(rounds=1, expansions=300, snap=False))
    assert solution.plan is None
    assert solution.statistics.counts["soft_duplicates"] > 10
