"""The second look at a scene without a plan: what stands in the way, and nothing that does not."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from mamo_planners.actions.pick_place import PickPlace
from mamo_planners.actions.push import Push
from mamo_planners.diagnosis import blocked_actions, diagnose
from mamo_planners.diagnosis.blocked_paths import PathFinder, count_who_is_stuck
from mamo_planners.diagnosis.blocked_retrieval import count_what_blocks
from mamo_planners.diagnosis.sparing import indispensable
from mamo_planners.mapf.solvers import portfolio
from mamo_planners.options import PickPlaceOptions, PushOptions, RetrievalOptions
from mamo_planners.retrieval import GraspAndExtract
from mamo_planners.search.judging import Judge
from mamo_planners.search.safety import SafetyMargin

from mamo_core.interfaces.action_generator import ActionRequest
from mamo_core.testing.fakes import StraightPush, StraightRetrieval
from mamo_core.testing.mapf_contract import instance, nowhere_to_go
from mamo_core.types.geometry import Box, Cylinder
from mamo_core.types.mapf import MAPFBudget, MAPFSolution, MAPFStatus
from mamo_core.types.region import SweptRegion
from mamo_core.types.rollout import RolloutResult, Violation
from mamo_core.types.scene import Mobility
from mamo_core.types.solution import Solution, SolutionStatus, Statistics

BUDGET = MAPFBudget(300, 60_000)


@pytest.mark.parametrize("needed", ["a", "bd", "acg", "ef", "abcdefgh"])
def test_all_that_is_needed_is_found_and_no_more(needed):
    asked = []

    def enough(kept):
        asked.append(set(kept))
        return set(needed) <= set(kept)

    assert indispensable("abcdefgh", enough) == tuple(needed)
    assert len(asked) <= 2 + 6 * len(needed)  # halves of 8: three levels, two questions each


def test_what_comes_first_is_spared_first():
    assert indispensable("abcd", lambda kept: "d" in kept) == ("d",)
    assert indispensable("abcd", lambda kept: len(kept) >= 2) == ("c", "d")
    assert indispensable("abcd", lambda kept: {"a", "c"} <= set(kept)) == ("a", "c")


def test_nothing_may_be_needed_and_all_may_not_be_enough():
    assert indispensable("abcd", lambda kept: True) == ()
    assert indispensable("abcd", lambda kept: False) is None


def stuck(problem, solver=None):
    statistics = Statistics()
    count_who_is_stuck(problem, PathFinder(solver or portfolio(), BUDGET), statistics)
    return {key: dict(statistics.involved[key]) for key in statistics.causes}


def test_what_hems_an_agent_in():
    (key,) = found = stuck(nowhere_to_go())
    assert key.startswith("a/mapf/no position outside the region can be reached")
    assert found[key] == {("wall",): 1}


def test_a_room_without_free_places_is_nobody_elses_fault():
    problem = instance(
        {"a": (0.06, 0.02)},
        (0.0, 0.0, 0.30, 0.04),
        (0.30, 0.04),
        walls={"wall": (0.17, 0.0, 0.19, 0.04)},
    )
    (key,) = found = stuck(problem)
    assert key.startswith("a/mapf/no position within the goal bounds")
    assert found[key] == {}


TWO_FOR_ONE = instance(
    {"a": (0.02, 0.02), "b": (0.07, 0.02), "c": (0.35, 0.02)},
    (0.0, 0.0, 0.10, 0.04),
    (0.40, 0.04),
    walls={"wall": (0.18, 0.0, 0.30, 0.04)},
)
"""A lane whose unswept end has room for one of a and b; c is elsewhere."""


def test_who_is_in_each_others_way():
    assert stuck(TWO_FOR_ONE) == {
        "a/mapf/no_paths_found": {("b",): 1},
        "b/mapf/no_paths_found": {("a",): 1},
    }


def test_what_a_solver_proves_is_told_from_what_it_does_not_find():
    class Sure:
        def solve(self, problem, budget, rng):
            both = {"a", "b"} <= {agent.name for agent in problem.agents}
            return MAPFSolution(MAPFStatus.INFEASIBLE if both else MAPFStatus.OPTIMAL)

    assert set(stuck(TWO_FOR_ONE, Sure())) == {"a/mapf/jammed", "b/mapf/jammed"}


WALL = (Box(np.array([0.02, 0.7, 0.28])), Mobility.IMMOVABLE, (0.58, -0.5))


@pytest.fixture(scope="module")
def walled(shelf_with):
    return shelf_with({"blocker": WALL})


@pytest.fixture(scope="module")
def walled_retrieval(walled, parts_of):
    return retrieval_of(walled, parts_of(walled))


def retrieval_of(problem, parts):
    equipment = parts.arm, parts.kinematics, parts.collision, parts.arm_planner
    return GraspAndExtract(problem, *equipment, RetrievalOptions())


def blocked(problem, retrieval):
    statistics = Statistics()
    count_what_blocks(problem, retrieval, statistics)
    return {key: dict(statistics.involved[key]) for key in statistics.causes}


def test_what_blocks_a_retrieval(walled, walled_retrieval):
    found = blocked(walled, walled_retrieval)
    assert found == {"target/retrieval/blocked": {("blocker",): 1}}


def test_nothing_blocks_a_retrieval_that_there_is(problem, parts):
    assert blocked(problem, retrieval_of(problem, parts)) == {}


def test_a_planner_without_something(walled, walled_retrieval):
    rng = np.random.default_rng(0)
    assert walled_retrieval.plan(walled.initial, rng, ignore_movables=True).motion is None
    opened = walled_retrieval.without(["blocker"])
    assert opened.plan(walled.initial, rng, ignore_movables=True).motion is not None


def test_a_planner_that_cannot_do_without_anything_says_why(walled):
    found = blocked(walled, StraightRetrieval(walled))
    assert set(found) == {"target/retrieval/blocked_by_blocker"}


def test_no_grasps(shelf_with, parts_of):
    problem = replace(shelf_with(), grasps=())
    found = blocked(problem, retrieval_of(problem, parts_of(problem)))
    assert set(found) == {"target/retrieval/no_grasps"}


def looked_at(problem, parts, **counts):
    searched = Statistics()
    searched.counts.update(counts)
    solution = Solution(SolutionStatus.BUDGET_EXHAUSTED, None, searched)
    retrieval = retrieval_of(problem, parts)
    search_parts = SimpleNamespace(
        problem=problem, retrieval=retrieval, mapf=portfolio(), actions=()
    )
    return diagnose(search_parts, solution, BUDGET, 0.015)


def test_movables_in_the_way_are_counted(problem, parts):
    found = looked_at(problem, parts)
    assert set(found.causes) == {"blocker/retrieval/in_the_way"}
    assert found.seconds["diagnosis"] > 0.0


def test_who_is_stuck_matters_where_the_search_found_no_paths(shelf_with, parts_of):
    wide = (Box(np.array([0.07, 0.78, 0.2])), Mobility.MOVABLE, (0.58, -0.5))
    problem = shelf_with({"blocker": wide})
    parts = parts_of(problem)
    keys = {"/".join(key.split("/")[:2]) for key in looked_at(problem, parts).causes}
    assert keys == {"blocker/retrieval", "blocker/mapf"}
    found = looked_at(problem, parts, mapf_calls=3, mapf_optimal=1)
    assert set(found.causes) == {"blocker/retrieval/in_the_way"}


BESIDE_A_BLOCK = {
    "blocker": (Box(np.array([0.07, 0.12, 0.2])), Mobility.MOVABLE, (0.58, -0.5)),
    "block": (Box(np.array([0.2, 0.2, 0.28])), Mobility.IMMOVABLE, (0.58, -0.67)),
    "post": (Cylinder(0.03, 0.2), Mobility.IMMOVABLE, (0.9, -0.2)),
}
"""The hand has to be where the block is to push the blocker away from it."""


@pytest.fixture(scope="module")
def beside(shelf_with):
    return shelf_with(BESIDE_A_BLOCK)


def blocked_action(problem, generator, kind, end):
    path = np.array([[0.58, -0.5], end])
    empty = SweptRegion(np.zeros(2), 0.1, np.full((2, 2), np.inf), 0.0)
    statistics = Statistics()
    request = ActionRequest("blocker", path, empty)
    blocked_actions.count_what_blocks(problem, kind, generator, request, statistics)
    return {key: dict(statistics.involved[key]) for key in statistics.causes}


def built(action, options, problem, parts):
    return action(problem, parts.arm, parts.kinematics, parts.collision, parts.arm_planner, options)


def test_what_blocks_a_push(beside, parts_of, problem, parts):
    push = built(Push, PushOptions(), beside, parts_of(beside))
    found = blocked_action(beside, push, "push", [0.58, -0.3])
    assert found == {"blocker/push/blocked": {("block",): 1}}
    push = built(Push, PushOptions(), problem, parts)
    assert blocked_action(problem, push, "push", [0.58, -0.3]) == {}


def test_what_blocks_a_pick(shelf_with, parts_of):
    block = Box(np.array([0.1, 0.2, 0.28]))
    between = {
        "blocker": (Cylinder(0.03, 0.2), Mobility.MOVABLE, (0.58, -0.5)),
        "one": (block, Mobility.IMMOVABLE, (0.58, -0.365)),
        "other": (block, Mobility.IMMOVABLE, (0.58, -0.635)),
    }
    problem = shelf_with(between)
    pick = built(PickPlace, PickPlaceOptions(), problem, parts_of(problem))
    (involved,) = blocked_action(problem, pick, "pick_place", [0.85, -0.3]).values()
    assert set(involved) <= {("one",), ("other",), ("one", "other")}


def test_a_generator_that_cannot_do_without_anything_blames_nobody(beside):
    class NoPush(StraightPush):
        def propose(self, state, request, rng, statistics):
            return iter(())

    assert blocked_action(beside, NoPush(beside), "push", [0.58, -0.3]) == {}


def result(problem, **changes):
    values = {
        "final_state": problem.initial,
        "violations": (),
        "moved": ("blocker",),
        "contacts": frozenset(),
        "stalled": False,
        "duration": 1.0,
        "steps": 500,
    }
    return RolloutResult(**{**values, **changes})


def violation(constraint, subject, other=None):
    return Violation(constraint, subject, other, 0.5, 1.0, 0.0)


@pytest.mark.parametrize(
    ("changes", "cause", "involved"),
    [
        (
            {"violations": (violation("contact", "blocker", "post"),)},
            "contact",
            ("blocker", "post"),
        ),
        ({"violations": (violation("tilt", "beside"),)}, "tilt", ("beside",)),
        (
            {"stalled": True, "contacts": frozenset({("robot", "post"), ("blocker", "base")})},
            "stalled",
            ("post",),
        ),
    ],
    ids=["contact", "tilt", "stalled"],
)
def test_the_judge_counts_who_is_involved(problem, parts, changes, cause, involved):
    statistics = Statistics()
    judge = Judge(parts.collision, SafetyMargin(problem, 0.0), statistics)
    action = SimpleNamespace(object_name="blocker", kind="push")
    assert not judge.good(result(problem, **changes), action, None)
    key = f"blocker/push/{cause}"
    assert statistics.causes == {key: 1}
    assert statistics.involved == {key: {involved: 1}}
    judge.retrieved(result(problem, **changes))
    assert statistics.involved[f"arm/retrieval/{cause}"] == {involved: 1}
