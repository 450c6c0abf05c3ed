"""What E-M4M and I-M4M do on tiny scenes, step by step. Each test carries its settings."""

from dataclasses import replace

import numpy as np
import pytest
from mamo_planners.search.options import Uncertainty
from mamo_planners.search.uncertainty import needed, sampled, stricter

from mamo_core.testing.fakes import StraightPush, StraightRetrieval
from mamo_core.testing.scenes import clear_scene, one_blocker, two_blockers, walled_in
from mamo_core.types.mapf import MAPFSolution, MAPFStatus
from mamo_core.types.problem import ConstraintSpec
from mamo_core.types.search_graph import GRAPHS
from mamo_core.types.solution import SolutionStatus
from mamo_core.verify import VerifyReport

A, B = "push a to 15,10", "push b to 30,-10"
SEARCHES = [("depth_first", False), ("depth_first", True), ("best_first", False)]


class NoPush(StraightPush):
    """Finds nothing."""

    def propose(self, state, request, rng, statistics):
        statistics.failed(request.object_name, "push", "no_ik")
        return iter(())


class NotBefore(StraightPush):
    """Cannot push ``name`` before ``other`` is out of the way: an order has to be found."""

    def __init__(self, problem, name, other):
        super().__init__(problem)
        self.name, self.other = name, other

    def propose(self, state, request, rng, statistics):
        place = self._problem.scene.index(self.other)
        start = self._problem.initial.object_poses[place]
        stands = np.linalg.norm(state.object_poses[place, :2] - start[:2]) < 0.05
        if request.object_name == self.name and stands:
            return iter(())
        return super().propose(state, request, rng, statistics)


@pytest.mark.parametrize(("kind", "lazy"), SEARCHES)
@pytest.mark.parametrize(
    ("scene", "actions"), [(clear_scene, []), (one_blocker, ["push a to 25,10"])]
)
def test_short_plans(search_of, in_words, scene, actions, kind, lazy):
    solution = search_of(scene().problem, kind=kind, lazy=lazy).solve()
    assert solution.status is SolutionStatus.SOLVED
    assert in_words(solution) == actions
    assert not +solution.statistics.causes


@pytest.mark.parametrize(
    ("kind", "lazy", "seed", "actions", "rollouts", "expansions"),
    [
        # Two rollouts for each push, alone and in line, and one of the retrieval.
        ("depth_first", False, 0, [A, B], 7, 2),
        ("depth_first", True, 0, [A, B], 5, 2),
        ("depth_first", True, 3, [B, A], 5, 2),
        ("best_first", False, 0, [A, B], 7, 2),
    ],
)
def test_two_blockers(search_of, in_words, kind, lazy, seed, actions, rollouts, expansions):
    options = {"positive_database": False}
    search = search_of(two_blockers().problem, kind=kind, lazy=lazy, **options)
    solution = search.solve(seed)
    assert in_words(solution) == actions
    counts = solution.statistics.counts
    assert counts["rollouts"] == rollouts
    assert counts["expansions"] == counts["mapf_calls"] == expansions
    assert len(search.mapf.problems) == expansions


@pytest.mark.parametrize("kind", ["depth_first", "best_first"])
def test_laziness_changes_the_work_not_the_claim(search_of, kind):
    plans = [search_of(two_blockers().problem, kind=kind, lazy=lazy) for lazy in (False, True)]
    eager, lazy = (search.solve() for search in plans)
    assert eager.status is lazy.status is SolutionStatus.SOLVED
    assert lazy.statistics.counts["rollouts"] <= eager.statistics.counts["rollouts"]
    assert all(s.replay(x.plan).ok for s, x in zip(plans, (eager, lazy), strict=True))


@pytest.mark.parametrize(("kind", "lazy"), SEARCHES)
def test_it_finds_the_order(search_of, in_words, kind, lazy):
    """The greedy thesis example of 7.1.1: b only once a is out of the way."""
    problem = two_blockers().problem
    push = NotBefore(problem, "b", "a")
    options = {"kind": kind, "lazy": lazy, "shared_penalty": 0.0}
    solution = search_of(problem, actions=[push], **options).solve()
    assert in_words(solution) == [A, B]


@pytest.mark.parametrize("lazy", [False, True])
def test_the_same_push_is_not_simulated_twice(search_of, in_words, lazy):
    """Both pushes are found at the root; the second one of the plan comes from the database."""
    problem = two_blockers().problem
    options = {"order": "breadth_first", "lazy": lazy, "expansions": 1, "agnostic": 0}
    with_, without = (
        search_of(problem, kind="best_first", positive_database=used, **options).solve()
        for used in (True, False)
    )
    assert in_words(with_) == in_words(without)
    assert with_.statistics.counts["database_hits"] >= 1
    assert without.statistics.counts["database_hits"] == 0
    assert with_.statistics.counts["database_refuted"] == 0
    assert with_.statistics.counts["rollouts"] < without.statistics.counts["rollouts"]


def test_orders_that_lead_to_the_same_rearrangement_meet(search_of):
    """Without a retrieval everything is tried; a then b is b then a."""
    refuse = search_of(
        two_blockers().problem,
        verifier=lambda plan: VerifyReport(("no",), None),
        kind="depth_first",
        regions=1,
        agnostic=0,
        expansions=1,
    )
    solution = refuse.solve()
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    assert solution.plan is None
    assert solution.statistics.counts["duplicates"] == 1


def test_failed_goals_are_told_to_mapf(search_of):
    problem = one_blocker().problem
    search = search_of(
        problem,
        actions=[NoPush(problem)],
        kind="depth_first",
        regions=1,
        expansions=3,
        agnostic=0,
        shared_penalty=0.0,
    )
    search.solve()
    forbidden = [
        [
            tuple(p.position.round(2))
            for agent in asked.agents
            for p in agent.penalties
            if np.isinf(p.cost)
        ]
        for asked in search.mapf.problems
    ]
    assert forbidden == [[], [(0.25, 0.1)], [(0.25, 0.1), (0.25, -0.1)]]


def test_valid_goals_are_hallucinated_once_nothing_else_is_new(search_of):
    """After a has been pushed in vain, the way it went is closed to MAPF, too."""
    search = search_of(
        one_blocker().problem,
        verifier=lambda plan: VerifyReport(("no",), None),
        kind="depth_first",
        regions=1,
        expansions=2,
        agnostic=0,
    )
    search.solve()
    start = one_blocker().problem.initial.object_poses[0, :2]
    at_the_root = [
        asked for asked in search.mapf.problems if (asked.agents[0].pose[:2] == start).all()
    ]
    assert [len(asked.agents[0].penalties) for asked in at_the_root] == [0, 1]
    assert np.allclose(at_the_root[1].agents[0].penalties[0].position, [0.25, 0.1])


def test_near_goals_are_penalised_only_with_the_database(search_of):
    problem = one_blocker().problem
    costs = []
    for used in (True, False):
        options = {"regions": 1, "expansions": 2, "agnostic": 0, "negative_database": used}
        search = search_of(problem, actions=[NoPush(problem)], kind="best_first", **options)
        search.solve()
        penalties = [p for agent in search.mapf.problems[1].agents for p in agent.penalties]
        costs.append([p.cost for p in penalties if np.isfinite(p.cost)])
    assert costs[0] == pytest.approx([3.0, 1.0, 2.0])
    assert costs[1] == []


def test_a_second_kind_of_action_is_tried_where_the_first_fails(search_of, in_words):
    problem = one_blocker().problem
    search = search_of(
        problem, actions=[NoPush(problem), StraightPush(problem)], kind="depth_first", lazy=True
    )
    solution = search.solve()
    assert in_words(solution) == ["push a to 25,10"]
    assert solution.statistics.counts["expansions"] == 1


class Twice(StraightPush):
    """Proposes everything twice, and nothing is what it was for; keeps what it was asked about."""

    def __init__(self, problem, alike):
        super().__init__(problem)
        self._alike, self.asked = alike, []

    def propose(self, state, request, rng, statistics):
        for action in super().propose(state, request, rng, statistics):
            yield from (action, action)

    def progress(self, before, request):
        return lambda after: False

    def alike(self, action, failed):
        self.asked.append((action, failed))
        return self._alike


@pytest.mark.parametrize("alike", [True, False])
def test_what_is_like_a_failure_is_not_tried_again_at_that_rearrangement(search_of, alike):
    problem = one_blocker().problem
    push = Twice(problem, alike)
    search = search_of(
        problem, actions=[push], kind="depth_first", regions=1, expansions=2, agnostic=0
    )
    counts = search.solve().statistics.counts
    assert counts["passed_over"] == (3 if alike else 0)
    assert counts["rollouts"] == (1 if alike else 4)
    assert all(action.kind == failed.kind == "push" for action, failed in push.asked)


def test_an_action_may_say_itself_what_it_must_have_brought_about(search_of, in_words):
    """Here, to have gone to the right; MAPF wants the left first."""

    class OnlyToTheRight(StraightPush):
        def progress(self, before, request):
            number = self._problem.scene.index(request.object_name)
            return lambda after: after.object_poses[number, 1] < before.object_poses[number, 1]

    problem = one_blocker().problem
    search = search_of(problem, actions=[OnlyToTheRight(problem)], kind="depth_first")
    solution = search.solve()
    assert in_words(solution) == ["push a to 25,-10"]
    assert solution.statistics.causes["a/push/no_gain"] == 1


def test_cheaper_kinds_come_first(search_of):
    problem = one_blocker().problem
    asked = []

    def named(name):
        class Push(StraightPush):
            def propose(self, *arguments):
                asked.append(name)
                return super().propose(*arguments)

        return Push(problem)

    costs = {"push": 2.0, "push1": 1.0}
    actions = [named("push"), named("push1")]
    search_of(problem, actions=actions, kind="depth_first", lazy=True, costs=costs).solve()
    assert asked == ["push1"]


def test_without_a_mapf_solution_actions_are_goal_agnostic(search_of, in_words):
    search = search_of(one_blocker().problem, kind="depth_first", lazy=True)
    search.mapf.solve = lambda problem, budget, rng: MAPFSolution(MAPFStatus.INFEASIBLE)
    assert in_words(search.solve()) == ["push a to 25,15"]


def test_another_region_is_drawn_when_nothing_is_left(search_of):
    problem = one_blocker().problem
    options = {"kind": "depth_first", "expansions": 1, "agnostic": 0, "regions": 3}
    solution = search_of(problem, actions=[NoPush(problem)], **options).solve()
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    assert solution.statistics.counts["regions"] == 3


class Asked(StraightRetrieval):
    """Knows how often it was asked to look at more grasps."""

    times = 0

    def thorough(self):
        self.times += 1
        return self


@pytest.mark.parametrize(("after", "times"), [(0, 1), (1, 1), (2, 0)])
def test_retrieval_looks_harder_after_so_many_regions(search_of, after, times):
    problem = one_blocker().problem
    retrieval = Asked(problem)
    search = search_of(
        problem,
        actions=[NoPush(problem)],
        retrieval=retrieval,
        kind="depth_first",
        regions=2,
        thorough_after=after,
    )
    assert search.solve().plan is None
    assert retrieval.times == times


def test_a_plan_that_fails_verification_is_never_returned(search_of):
    options = {"kind": "depth_first", "regions": 2, "expansions": 2}
    refuse = search_of(
        one_blocker().problem, verifier=lambda plan: VerifyReport(("no",), None), **options
    )
    solution = refuse.solve()
    assert solution.plan is None
    assert solution.statistics.causes["plan/verification/no"] >= 2


def test_hopeless(search_of):
    search = search_of(walled_in().problem, kind="depth_first", hopeless_regions=2, draws=3)
    solution = search.solve()
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    assert solution.reason == "no way to retrieve target even without movables: blocked_by_w"
    assert solution.statistics.counts["rollouts"] == 0


def test_actions_are_limited(search_of):
    options = {"kind": "depth_first", "max_actions": 1, "regions": 1}
    solution = search_of(two_blockers().problem, **options).solve()
    assert solution.plan is None


class ShortAtFirst(StraightPush):
    """Its first push goes only a part of the way."""

    def __init__(self, problem):
        super().__init__(problem)
        self.calls = 0

    def propose(self, state, request, rng, statistics):
        self.calls += 1
        if self.calls == 1:
            start, end = request.path[0], request.path[-1]
            request = replace(request, path=np.array([start, start + 0.3 * (end - start)]))
        return super().propose(state, request, rng, statistics)


@pytest.mark.parametrize(("improve", "actions", "regions"), [(0, 2, 1), (1, 1, 2), (5, 1, 2)])
def test_better_plans_are_looked_for_on_request(search_of, improve, actions, regions):
    problem = one_blocker().problem
    options = {"kind": "depth_first", "regions": 9, "improve": improve}
    solution = search_of(problem, actions=[ShortAtFirst(problem)], **options).solve()
    assert len(solution.plan.actions) == actions
    assert solution.statistics.counts["regions"] == regions


def test_the_best_plan_stays_if_none_is_better(search_of, in_words):
    options = {"kind": "depth_first", "regions": 9, "improve": 2, "visits": 4, "expansions": 2}
    solution = search_of(two_blockers().problem, **options).solve()
    assert in_words(solution) == [A, B]
    assert solution.statistics.counts["regions"] == 3


def test_no_budget(search_of):
    solution = search_of(two_blockers().problem, kind="depth_first").solve(seconds=0.0)
    assert solution.status is SolutionStatus.BUDGET_EXHAUSTED
    assert solution.statistics.counts["rollouts"] == 0


def spied(search, executed):
    """The search, with ``executed(real, stand, action, accept)`` in place of the execution's."""
    make = search.search._parts.execution

    def execution(*arguments):
        made = make(*arguments)
        real = made.executed
        made.executed = lambda stand, action, accept: executed(real, stand, action, accept)
        return made

    search.search._parts = replace(search.search._parts, execution=execution)
    return search


DATABASE = {"kind": "best_first", "order": "breadth_first", "expansions": 1, "agnostic": 0}


def test_what_the_database_says_is_executed_before_it_counts(search_of):
    from_where = []

    def executed(real, stand, action, accept):
        from_where.append(stand.predicted)
        return real(stand, action, accept)

    solution = spied(search_of(two_blockers().problem, **DATABASE), executed).solve()
    counts = solution.statistics.counts
    assert counts["database_hits"] >= 1
    assert not any(from_where)
    # Alone and in line; a hit that is expanded in line only; and the retrieval.
    assert counts["rollouts"] == 2 * counts["valid_rollouts"] + len(from_where) + 1


def test_what_the_database_says_may_be_refuted(search_of):
    """A push that does not do again what it did ends there, and leaves its place to others."""
    search = search_of(two_blockers().problem, regions=1, **DATABASE)
    solution = spied(search, lambda real, stand, action, accept: None).solve()
    counts = solution.statistics.counts
    assert counts["database_refuted"] == counts["database_hits"] == 2
    (graph,) = solution.info[GRAPHS]
    refuted = [edge for edge in graph.edges if edge.causes == ("not_reproduced",)]
    assert [edge.end for edge in refuted] == [None, None]
    assert not any(vertex.predicted for vertex in graph.vertices)
    assert counts["duplicates"] == 0
    assert solution.plan is None
    assert solution.reason == "nothing is left to try"


def exactly(simulators=1, copies=1, threshold=1.0):
    return Uncertainty(
        simulators=simulators,
        copies=copies,
        threshold=threshold,
        mass_spread=0.0,
        friction_spread=0.0,
    )


@pytest.mark.parametrize("uncertainty", [exactly(), exactly(2, 3)])
def test_without_noise_robust_is_plain(search_of, uncertainty):
    problem = two_blockers().problem
    options = {"kind": "depth_first", "lazy": True}
    plain = search_of(problem, **options).solve(3)
    robust = search_of(problem, uncertainty=uncertainty, **options).solve(3)
    assert [m.duration for m in plain.plan.motions] == [m.duration for m in robust.plan.motions]
    for one, other in zip(plain.plan.motions, robust.plan.motions, strict=True):
        for a, b in zip(one.segments, other.segments, strict=True):
            assert np.array_equal(a.trajectory.positions, b.trajectory.positions)
    extra = uncertainty.samples - 1
    expected = plain.statistics.counts["rollouts"] + extra * len(plain.plan.actions)
    assert robust.statistics.counts["rollouts"] == expected


@pytest.mark.parametrize(("threshold", "solved"), [(1.0, False), (0.5, True)])
def test_so_many_samples_may_fail(search_of, threshold, solved, monkeypatch):
    """Of four samples one has objects too heavy to push."""
    problem = one_blocker().problem
    search = search_of(
        problem,
        kind="depth_first",
        uncertainty=exactly(4, 1, threshold),
        expansions=1,
        agnostic=0,
    )
    rollout = search.model.rollout

    def heavier(state, motion, *, parameters=None, **more):
        if parameters is search.engines[-1].parameters:
            parameters = replace(parameters, masses=dict.fromkeys(parameters.masses, 50.0))
        return rollout(state, motion, parameters=parameters, **more)

    monkeypatch.setattr(search.model, "rollout", heavier)
    solution = search.solve()
    assert (solution.status is SolutionStatus.SOLVED) == solved
    assert solution.statistics.causes["a/push/stalled"] >= 1


def test_the_law_of_the_samples():
    scene = two_blockers().problem.scene
    drawn = sampled(scene, Uncertainty(simulators=100), np.random.default_rng(0))
    masses = np.array([values.masses["a"] for values in drawn]) / 0.2
    frictions = np.array([values.frictions["a"] for values in drawn]) / 0.5
    assert len(drawn) == 200
    assert masses.std() == pytest.approx(0.2, rel=0.2)
    assert 0.5 <= frictions.min() < 0.6
    assert 1.9 < frictions.max() <= 2.0
    assert sorted(drawn[0].masses) == ["a", "b", "c", "target"]
    assert Uncertainty().samples == 12
    assert [needed(t, 12) for t in (0.9, 0.01, 1.0)] == [10, 1, 12]


def test_stratified_samples_have_one_value_in_each_part():
    scene = two_blockers().problem.scene
    uncertainty = Uncertainty(simulators=4, copies=1, stratified=True)
    for seed in range(20):
        drawn = sampled(scene, uncertainty, np.random.default_rng(seed))
        masses = sorted(values.masses["a"] for values in drawn)
        quartiles = [0.2 * (1.0 + 0.2 * z) for z in (-0.6745, 0.0, 0.6745)]
        assert np.searchsorted(quartiles, masses).tolist() == [0, 1, 2, 3]


def test_objects_and_masses_are_shuffled_apart():
    scene = two_blockers().problem.scene
    uncertainty = Uncertainty(simulators=50, stratified=True)
    drawn = sampled(scene, uncertainty, np.random.default_rng(0))
    columns = [[v.masses["a"] for v in drawn], [v.masses["b"] for v in drawn]]
    columns.append([v.frictions["a"] for v in drawn])
    assert np.abs(np.corrcoef(columns) - np.eye(3)).max() < 0.3


def test_samples_have_stricter_limits():
    problem = replace(
        two_blockers().problem,
        constraints=(
            ConstraintSpec("contact", {"clearance": 0.002}),
            ConstraintSpec("tilt"),
            ConstraintSpec("speed", {"limit": 2.0}),
            ConstraintSpec("bounds"),
        ),
    )
    specs = stricter(problem, Uncertainty(clearance=0.005, limit_share=0.5)).constraints
    assert {spec.name: spec.options for spec in specs} == {
        "contact": {"clearance": 0.005},
        "tilt": {"limit_deg": 12.5},
        "speed": {"limit": 1.0},
        "bounds": {},
    }
    keeping = stricter(problem, Uncertainty(limit_share=0.5)).constraints[0]
    assert keeping.options == {"clearance": 0.002}
    assert stricter(problem, Uncertainty()) is problem
