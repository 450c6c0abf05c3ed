"""What the greedy search does on tiny scenes, step by step. Each test carries its settings."""

from dataclasses import replace

import numpy as np
import pytest

from mamo_core.interfaces.retrieval import Retrieval
from mamo_core.testing.fakes import StraightPush
from mamo_core.testing.gantry import GantryKinematics
from mamo_core.testing.quasi_static import QuasiStaticModel
from mamo_core.testing.scenes import clear_scene, one_blocker, two_blockers, walled_in
from mamo_core.testing.transition_cases import standard_constraints
from mamo_core.types.mapf import MAPFSolution, MAPFStatus
from mamo_core.types.rollout import Violation
from mamo_core.types.solution import SolutionStatus
from mamo_core.verify import VerifyReport

A, B = "push a to 15,10", "push b to 30,-10"


@pytest.mark.parametrize("iterate", [True, False])
@pytest.mark.parametrize(
    ("scene", "seed", "actions", "rollouts"),
    [
        # One rollout of the retrieval, and two for each push: alone, and in line.
        (clear_scene, 0, [], 1),
        (one_blocker, 0, ["push a to 25,10"], 3),
        (two_blockers, 0, [A, B], 5),
        (two_blockers, 3, [B, A], 5),
        (two_blockers, 7, [A, B], 5),
    ],
)
def test_actions(search_of, in_words, scene, seed, actions, rollouts, iterate):
    solution = search_of(scene().problem, iterate=iterate).solve(seed)
    assert solution.status is SolutionStatus.SOLVED
    assert in_words(solution) == actions
    counts = solution.statistics.counts
    assert counts["rollouts"] == rollouts
    assert counts["valid_rollouts"] == len(actions)
    assert counts["attempts"] == 1
    assert counts["retrievals"] == len(actions) + 1
    assert not +solution.statistics.causes


@pytest.mark.parametrize(("iterate", "calls"), [(True, 2), (False, 1)])
def test_mapf_calls(search_of, iterate, calls):
    search = search_of(two_blockers().problem, iterate=iterate)
    solution = search.solve()
    assert len(search.mapf.problems) == calls
    assert solution.statistics.counts["mapf_calls"] == calls


def test_mapf_sees_the_state_after_every_push(search_of):
    search = search_of(two_blockers().problem)
    solution = search.solve()
    first, second = search.mapf.problems
    before, after = ({a.name: a.pose for a in p.agents} for p in (first, second))
    (moved,) = [n for n in before if not np.array_equal(before[n], after[n])]
    assert moved == solution.plan.actions[0].object_name
    assert sorted(before) == ["a", "b", "c"]
    assert [o.name for o in first.obstacles] == ["target"]
    assert np.array_equal(first.region.lowest, second.region.lowest)


@pytest.mark.parametrize("seed", [0, 3])
def test_same_seed_same_plan(search_of, seed):
    plans = [search_of(two_blockers().problem).solve(seed).plan for _ in range(2)]
    for one, other in zip(plans[0].motions, plans[1].motions, strict=True):
        for a, b in zip(one.segments, other.segments, strict=True):
            assert np.array_equal(a.trajectory.positions, b.trajectory.positions)
            assert np.array_equal(a.trajectory.times, b.trajectory.times)


def test_progress_is_told(search_of):
    search = search_of(two_blockers().problem)
    search.solve()
    assert search.told == [
        "attempt 1",
        "0 actions, 2 objects in the way",
        "1 actions, 1 objects in the way",
    ]


def test_hopeless_without_proof(search_of):
    search = search_of(walled_in().problem, hopeless_attempts=2, regions=3)
    solution = search.solve()
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    assert solution.plan is None
    assert solution.reason == ("no way to retrieve target even without movables: blocked_by_w")
    assert solution.statistics.causes["target/retrieval/blocked_by_w"] == 6
    assert solution.statistics.counts["rollouts"] == 0
    assert search.mapf.problems == []


@pytest.mark.parametrize("cause", ["out_of_reach", "gripper_too_small"])
def test_hopeless_and_proved(search_of, cause):
    class Never:
        def plan(self, state, rng, *, ignore_movables=False, avoid=()):
            return Retrieval(None, causes={cause: 2})

    solution = search_of(one_blocker().problem, retrieval=Never()).solve()
    assert solution.status is SolutionStatus.NO_PLAN_PROVED
    assert solution.reason.endswith(f": {cause}")


def test_a_plan_that_fails_verification_is_never_returned(search_of):
    asked = []

    def refuse(plan):
        asked.append(plan)
        return VerifyReport(("tilt: a at 1.000 s",), None)

    search = search_of(one_blocker().problem, verifier=refuse, attempts=3)
    solution = search.solve()
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    assert solution.plan is None
    assert len(asked) >= 3
    assert solution.statistics.causes["plan/verification/tilt: a at 1.000 s"] == len(asked)


def test_a_plan_that_passes_later_is_returned(search_of, in_words):
    answers = iter([VerifyReport(("no",), None), VerifyReport((), None)])
    solution = search_of(
        one_blocker().problem, verifier=lambda plan: next(answers), attempts=5
    ).solve()
    assert solution.status is SolutionStatus.SOLVED
    assert solution.statistics.counts["attempts"] == 2
    assert in_words(solution) == ["push a to 25,10"]


def test_no_budget(search_of):
    search = search_of(two_blockers().problem)
    solution = search.solve(seconds=0.0)
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    assert solution.reason == "no plan within the budget"
    assert solution.plan is None
    assert solution.statistics.counts["rollouts"] == 0
    assert search.mapf.problems == []


def test_attempts_are_limited(search_of):
    class NoPush(StraightPush):
        def propose(self, state, request, rng, statistics):
            statistics.failed(request.object_name, "push", "no_ik")
            return iter(())

    problem = one_blocker().problem
    solution = search_of(problem, actions=[NoPush(problem)], attempts=2).solve()
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    assert solution.statistics.counts["attempts"] == 2
    # Guided and goal-agnostic requests fail for the same reason, and are counted.
    assert solution.statistics.causes["a/push/no_ik"] > 2


def test_failed_goals_are_forbidden_in_the_next_round(search_of):
    """Each MAPF call knows the goals that no push reached."""

    class NoPush(StraightPush):
        def propose(self, state, request, rng, statistics):
            return iter(())

    problem = one_blocker().problem
    search = search_of(problem, actions=[NoPush(problem)], attempts=1, rounds=3)
    search.solve()
    penalties = [next(a.penalties for a in p.agents if a.name == "a") for p in search.mapf.problems]
    assert [len(p) for p in penalties] == [0, 1, 2]
    assert penalties[1][0].cost == float("inf")
    np.testing.assert_allclose(penalties[1][0].position, [0.25, 0.10])


def test_without_a_mapf_solution_pushes_are_goal_agnostic(search_of, in_words):
    search = search_of(one_blocker().problem)
    search.mapf.solve = lambda problem, budget, rng: MAPFSolution(
        MAPFStatus.INFEASIBLE, blame={"a": "no_goal"}
    )
    solution = search.solve()
    assert solution.status is SolutionStatus.SOLVED
    assert in_words(solution) == ["push a to 25,15"]
    assert solution.statistics.causes["a/mapf/no_goal"] >= 1


def test_a_push_that_does_not_help_is_no_gain(search_of):
    """Goal-agnostic pushes must leave less of the region occupied."""

    class Nudge(StraightPush):
        def propose(self, state, request, rng, statistics):
            start = state.object_poses[self._problem.scene.index(request.object_name), :2]
            short = replace(request, path=start + np.array([[0.0, 0.0], [0.03, 0.0]]))
            return super().propose(state, short, rng, statistics)

    problem = one_blocker().problem
    search = search_of(problem, actions=[Nudge(problem)], attempts=1, agnostic=2)
    search.mapf.solve = lambda problem, budget, rng: MAPFSolution(MAPFStatus.INFEASIBLE)
    solution = search.solve()
    assert solution.plan is None
    assert solution.statistics.causes["a/push/no_gain"] == 2
    assert solution.statistics.counts["valid_rollouts"] == 0


def test_actions_are_limited(search_of):
    solution = search_of(two_blockers().problem, max_actions=1, attempts=2).solve()
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    assert solution.statistics.counts["valid_rollouts"] == 2


def test_pushes_that_break_constraints_are_not_committed(search_of):
    """The first generator pushes into the target; the second is asked next."""

    class IntoTheTarget(StraightPush):
        def propose(self, state, request, rng, statistics):
            start = state.object_poses[self._problem.scene.index(request.object_name), :2]
            ahead = replace(request, path=start + np.array([[0.0, 0.0], [0.2, 0.0]]))
            return super().propose(state, ahead, rng, statistics)

    problem = one_blocker().problem
    search = search_of(problem, actions=[IntoTheTarget(problem), StraightPush(problem)])
    solution = search.solve()
    assert solution.status is SolutionStatus.SOLVED
    assert len(solution.plan.actions) == 1
    assert solution.statistics.causes["a/push/contact"] == 1
    assert solution.statistics.counts["rollouts"] == 4


class Rejects(QuasiStaticModel):
    """Finds something wrong with whatever moves ``name``, after having let ``passes`` through."""

    def __init__(self, problem, name, passes=0, lost=None):
        super().__init__(problem, GantryKinematics().forward, standard_constraints(problem))
        self.name, self.passes, self.lost = name, passes, lost

    def rollout(self, *args, **more):
        result = super().rollout(*args, **more)
        if self.name not in result.moved:
            return result
        self.passes -= 1
        if self.passes >= 0:
            return result
        if self.lost is not None:
            return replace(result, lost=self.lost)
        return replace(result, violations=(Violation("tilt", self.name, None, 0.1, 1.0, 0.4),))


def test_other_engines_are_asked_and_their_no_counts(search_of):
    problem = one_blocker().problem
    solution = search_of(problem, others=[("strict", Rejects(problem, "a"))], attempts=2).solve()
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    causes = solution.statistics.causes
    assert causes["a/push/not_valid_in_strict"] == causes["a/push/tilt"] > 0


def test_other_engines_go_on_from_their_own_state(search_of, in_words):
    problem = two_blockers().problem
    agreeing = QuasiStaticModel(problem, GantryKinematics().forward, standard_constraints(problem))
    solution = search_of(problem, others=[("same", agreeing)]).solve()
    assert in_words(solution) == [A, B]
    # Alone, in line and in the other engine for each push; the retrieval in both.
    assert solution.statistics.counts["rollouts"] == 3 * 2 + 2


def test_a_lost_rollout_costs_no_more_than_that_rollout(search_of, in_words):
    problem = one_blocker().problem
    engine = Rejects(problem, "a", lost="the engine's process died (exit code -9)")
    search = search_of(problem, model=_dies_once(engine))
    solution = search.solve()
    assert solution.status is SolutionStatus.SOLVED
    key = "a/push/the engine's process died (exit code -9)"
    assert solution.statistics.causes[key] == 1


def _dies_once(engine):
    """Loses the first rollout that moves the object, and none after it."""
    sound, rollout = QuasiStaticModel.rollout, engine.rollout

    def once(*args, **more):
        result = rollout(*args, **more)
        if result.lost is not None:
            engine.rollout = lambda *a, **m: sound(engine, *a, **m)
        return result

    engine.rollout = once
    return engine


def test_work_of_other_processes_counts(search_of):
    class Elsewhere(QuasiStaticModel):
        def rollout(self, *args, **more):
            return replace(super().rollout(*args, **more), outside_cpu=10.0)

    problem = one_blocker().problem
    model = Elsewhere(problem, GantryKinematics().forward, standard_constraints(problem))
    solution = search_of(problem, model=model).solve(seconds=15.0)
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    assert solution.statistics.seconds["rollouts"] >= 20.0
