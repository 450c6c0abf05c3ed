"""Which of all that was counted is said to be the reason, and in which words."""

from dataclasses import replace

import pytest

from mamo_core.explain import Obstruction, explain
from mamo_core.problems import load_problem
from mamo_core.types.problem import ConstraintSpec, Task
from mamo_core.types.solution import Solution, SolutionStatus, Statistics

SCENE = """\
schema_version: 1
name: three_things
robot: {name: pr2_right_arm, joints: [0, 0, 0, 0, 0, 0, 0]}
workspace: {lower: [0, -0.5, 0], upper: [1, 0.5, 1]}
fixtures:
  - {name: board, box: [1, 1, 0.04], position: [0.5, 0, -0.02]}
objects:
  - {name: t, box: [0.06, 0.06, 0.2], position: [0.5, 0.2, 0.1], mass: 0.4, friction: 0.5}
  - {name: a, box: [0.06, 0.06, 0.2], position: [0.3, 0.2, 0.1], mass: 0.4, friction: 0.5}
  - {name: b, box: [0.06, 0.06, 0.2], position: [0.3, 0.0, 0.1], mass: 0.4, friction: 0.5}
  - {name: v, box: [0.06, 0.06, 0.2], position: [0.3, -0.2, 0.1], mobility: immovable, mass: 0.4,
     friction: 0.5}
target: t
grasps:
  - {position: [-0.1, 0, 0], approach: 0.1, opening: 0.07}
"""
"""a and b are movable."""


@pytest.fixture(scope="module")
def problem(tmp_path_factory):
    path = tmp_path_factory.mktemp("explain") / "three_things.yaml"
    path.write_text(SCENE)
    return load_problem(path)


def counted(*failures, worked=(), looked=False):
    """Failures (subject, action, cause, times, *involved)."""
    statistics = Statistics()
    for subject, action, cause, times, *involved in failures:
        statistics.failed(subject, action, cause, times, tuple(involved))
    for subject, action in worked:
        statistics.succeeded(subject, action)
    if looked:
        statistics.seconds["diagnosis"] += 0.1
    return statistics


def why(problem, searched, found=None, reason=""):
    solution = Solution(SolutionStatus.BUDGET_EXHAUSTED, None, searched, reason)
    return explain(problem, solution, found)


EVERYTHING = counted(
    ("t", "retrieval", "hand_blocked", 9),
    ("a", "mapf", "stuck", 9),
    ("a", "push", "tilt", 9, "a"),
    ("arm", "retrieval", "contact", 9, "robot", "v"),
)


def test_no_retrieval_comes_first(problem):
    found = counted(("t", "retrieval", "blocked", 1, "v", "board"), ("a", "mapf", "stuck", 1))
    said = why(problem, EVERYTHING, found)
    assert said.obstruction is Obstruction.RETRIEVAL
    assert said.subjects == ("t",)
    assert set(said.involved) == {"v", "board"}
    assert said.headline == (
        "no way was found to take out t, even with all movables gone: "
        "the fixture board and the immovable v are in the way "
        "(mostly: there is no room for the hand)"
    )


def test_then_paths(problem):
    found = counted(("a", "retrieval", "in_the_way", 4), ("a", "mapf", "stuck", 1, "v", "t"))
    said = why(problem, EVERYTHING, found)
    assert said.obstruction is Obstruction.PATHS
    assert said.headline == (
        "a cannot get out of the way of the retrieval: stuck; "
        "around it: the target and the immovable v"
    )


def test_then_actions(problem):
    said = why(problem, EVERYTHING, counted(("a", "retrieval", "in_the_way", 4)))
    assert said.obstruction is Obstruction.ACTION
    assert said.headline == (
        "a stands in the way, and no action moved it: with push it tips over (9 of 9 simulated)"
    )


def test_then_the_execution(problem):
    said = why(problem, EVERYTHING, counted(looked=True))
    assert said.obstruction is Obstruction.EXECUTION
    assert said.headline == (
        "nothing stands in the way, but what was executed failed: "
        "the immovable v is touched (9 of 9 simulated)"
    )


def test_a_retrieval_that_failed_now_and_then_is_no_reason(problem):
    """Grasps are drawn: only a second look says that none of them works."""
    searched = counted(("t", "retrieval", "hand_blocked", 99), ("a", "push", "stalled", 1))
    assert why(problem, searched).obstruction is Obstruction.ACTION
    found = counted(("a", "retrieval", "in_the_way", 4))
    assert why(problem, searched, found).obstruction is Obstruction.ACTION


def test_where_nobody_looked_the_search_may_have_tried_nothing_else(problem):
    said = why(problem, counted(("t", "retrieval", "out_of_reach", 5)))
    assert said.obstruction is Obstruction.RETRIEVAL
    said = why(problem, counted(("t", "retrieval", "x", 5), ("b", "mapf", "stuck", 2)))
    assert said.obstruction is Obstruction.PATHS
    assert said.subjects == ("b",)


def test_what_was_simulated_counts_more_than_what_was_not(problem):
    searched = counted(
        ("a", "push", "no_ik", 500), ("a", "push", "tilt", 3), ("a", "push", "contact", 5, "a", "v")
    )
    said = why(problem, searched)
    assert said.causes == ("contact",)
    assert "with push the immovable v is touched (5 of 8 simulated)" in said.headline


def test_every_action_is_named(problem):
    searched = counted(
        ("a", "lift", "no_ik", 2), ("a", "push", "stalled", 1), ("a", "pull", "x", 1)
    )
    assert why(problem, searched).headline.endswith(
        "with push the arm stalls (1 of 1 simulated), "
        "with lift no arm configuration brings the hand behind it (2 times), with pull x (once)"
    )


@pytest.mark.parametrize(
    ("found", "worked", "first"),
    [
        ([("a", "retrieval", "in_the_way", 1), ("b", "retrieval", "in_the_way", 4)], [], "b"),
        ([("a", "retrieval", "in_the_way", 4), ("b", "retrieval", "in_the_way", 4)], [], "a"),
        (
            [("a", "retrieval", "in_the_way", 4), ("b", "retrieval", "in_the_way", 4)],
            [("a", "push")],
            "b",
        ),
        ([("b", "retrieval", "in_the_way", 4)], [("b", "push")], "b"),
    ],
    ids=["in more ways", "more failures", "never moved", "in the way at all"],
)
def test_which_movable_is_named(problem, found, worked, first):
    searched = counted(("a", "push", "tilt", 9), ("b", "push", "tilt", 3), worked=worked)
    assert why(problem, searched, counted(*found)).subjects == (first,)


def test_an_object_that_was_moved_is_not_said_to_be_stuck(problem):
    searched = counted(("a", "push", "tilt", 2), worked=[("a", "push"), ("a", "push")])
    headline = why(problem, searched, counted(("a", "retrieval", "in_the_way", 4))).headline
    assert "a stands in the way, and that it was moved 2 times did not help: with push" in headline


def test_the_search_may_end_before_it_tried_anything(problem):
    said = why(problem, counted(), counted(("a", "retrieval", "in_the_way", 4)))
    assert said.headline == "a stands in the way, and the search ended before it was moved"


def test_who_else_tips_is_named(problem):
    said = why(problem, counted(("a", "push", "tilt", 7, "b"), ("a", "push", "tilt", 2, "a")))
    assert "with push b tips over (9 of 9 simulated)" in said.headline
    said = why(problem, counted(("a", "push", "tilt", 2, "b"), ("a", "push", "tilt", 7, "a")))
    assert "with push it tips over (9 of 9 simulated)" in said.headline


def test_of_what_touched_something_movables_are_not_blamed(problem):
    said = why(problem, counted(("a", "push", "contact", 7, "b", "v")))
    assert "with push the immovable v is touched (7 of 7 simulated)" in said.headline
    assert said.details[0].involved == (("b", 7), ("v", 7))


@pytest.mark.parametrize(
    ("others", "words"),
    [
        (("v",), "the immovable v is in the way"),
        (("v", "board"), "the fixture board and the immovable v are in the way"),
    ],
)
def test_what_blocks_an_action_that_was_never_simulated(problem, others, words):
    found = counted(("a", "retrieval", "in_the_way", 4), ("a", "push", "blocked", 1, *others))
    said = why(problem, counted(("a", "push", "no_ik", 30)), found)
    assert said.headline.endswith(
        f"with push {words} (mostly: no arm configuration brings the hand behind it)"
    )
    said = why(problem, counted(("a", "push", "no_ik", 30), ("a", "push", "tilt", 1)), found)
    assert said.headline.endswith("with push it tips over (1 of 1 simulated)")


def test_unknown_causes_are_said_as_they_are(problem):
    said = why(problem, counted(("a", "shove", "too shy / today", 3)))
    assert said.headline.endswith("with shove too shy / today (3 times)")
    (detail,) = said.details
    assert (detail.cause, detail.words) == ("too shy / today", "too shy / today")


def test_constraints_of_plugins_are_found_out_by_simulating(problem):
    searched = counted(("a", "push", "no_ik", 50), ("a", "push", "spill", 2))
    assert why(problem, searched).causes == ("no_ik",)
    spilling = replace(problem, constraints=(*problem.constraints, ConstraintSpec("spill")))
    assert why(spilling, searched).causes == ("spill",)


def test_nothing_that_was_counted_is_dropped(problem):
    found = counted(("a", "retrieval", "in_the_way", 4), ("a", "push", "tilt", 1))
    details = why(problem, EVERYTHING, found).details
    assert [(d.subject, d.action, d.times) for d in details] == [
        ("a", "mapf", 9),
        ("a", "push", 9),
        ("arm", "retrieval", 9),
        ("t", "retrieval", 9),
        ("a", "retrieval", 4),
    ]


def test_a_reach_is_told_by_what_failed_most_often(problem):
    reach = replace(problem, task=Task.REACH)
    said = why(reach, counted(("a", "reach", "tilt", 2), ("robot", "reach", "stalled", 3)))
    assert said.obstruction is Obstruction.UNKNOWN
    assert said.headline == "what failed most often is reach of robot: the arm stalls (3 times)"


def test_what_an_arm_touches_while_it_reaches_is_no_action(problem):
    said = why(problem, counted(("a", "reach", "tilt", 2)))
    assert said.headline == "what failed most often is reach of a: it tips over (2 times)"


def test_where_nothing_was_counted_the_search_has_the_word(problem):
    assert why(problem, counted(), reason="no plan within the budget").headline == (
        "no plan within the budget"
    )
    assert why(problem, counted()).headline == "the search counted nothing that failed"
