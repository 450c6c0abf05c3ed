"""What the backwards search does on tiny scenes. Each test carries its settings."""

import pytest

from mamo_core.testing.fakes import StraightPush
from mamo_core.testing.scenes import clear_scene, one_blocker, two_blockers, walled_in
from mamo_core.types.solution import SolutionStatus
from mamo_core.verify import VerifyReport

EXACT = {"goal_spread": 0.0}


@pytest.mark.parametrize(
    ("scene", "pushed"), [(clear_scene, []), (one_blocker, ["a"]), (two_blockers, ["a", "b"])]
)
def test_every_object_in_the_way_is_pushed_once(search_of, scene, pushed):
    solution = search_of(scene().problem, kind="dogar", attempts=20).solve()
    assert solution.status is SolutionStatus.SOLVED
    assert sorted(action.object_name for action in solution.plan.actions) == pushed


class Asked(StraightPush):
    """Keeps the objects in the order in which pushes of them were asked for."""

    def __init__(self, problem):
        super().__init__(problem)
        self.names = []

    def propose(self, state, request, rng, statistics):
        self.names.append(request.object_name)
        return super().propose(state, request, rng, statistics)


def test_what_was_found_last_is_executed_first(search_of):
    problem = two_blockers().problem
    push = Asked(problem)
    solution = search_of(problem, actions=[push], kind="dogar", attempts=1).solve()
    executed = [action.object_name for action in solution.plan.actions]
    assert list(dict.fromkeys(push.names)) == executed[::-1]


def test_an_object_goes_to_the_closest_place_outside(search_of, in_words):
    solution = search_of(one_blocker().problem, kind="dogar", attempts=1, **EXACT).solve()
    assert in_words(solution) == ["push a to 25,-10"]


def test_no_plan_without_a_retrieval(search_of):
    solution = search_of(walled_in().problem, kind="dogar").solve()
    assert solution.plan is None
    assert "no way to retrieve" in solution.reason


def test_a_plan_that_does_not_hold_is_not_returned(search_of):
    def refuse(plan):
        return VerifyReport(("it fell",), None, ("bounds",))

    solution = search_of(one_blocker().problem, kind="dogar", attempts=3, verifier=refuse).solve()
    assert solution.plan is None
    assert solution.statistics.counts["attempts"] == 3
    assert solution.statistics.causes["plan/verification/it fell"] == 3
