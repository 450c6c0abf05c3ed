"""Scenes without a plan: what is said must name the right thing and the right reason.

They are planned as `mamo plan` does it, with the real robot and engine, and end by themselves.
"""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pytest

from mamo_core.compose import compose
from mamo_core.explain import Obstruction, explain
from mamo_core.plugins import discover
from mamo_core.problems import load_problem
from mamo_core.recipe_sets import chosen_recipe
from mamo_core.types.problem import DEFAULT_CONSTRAINTS

FOLDER = Path(__file__).resolve().parents[3] / "problems" / "impossible"
SETTINGS = ("search.regions=2", "search.hopeless_regions=1")
SECONDS = 60.0
"""Far more than is needed: the settings end the search."""


class Why(NamedTuple):
    obstruction: Obstruction
    subjects: set[str]
    cause: str
    involved: set[str]
    words: tuple[str, ...]


NO_GOAL = "no position within the goal bounds is outside the region and not forbidden"
NO_WAY = "no position outside the region can be reached past the obstacles and bounds"
WHY = {
    "walled_in": Why(
        Obstruction.RETRIEVAL,
        {"target"},
        "blocked",
        {"gate"},
        ("no way was found to take out target", "the immovable gate is in the way"),
    ),
    "out_of_reach": Why(
        Obstruction.RETRIEVAL,
        {"target"},
        "out_of_reach",
        set(),
        ("no way was found to take out target", "out of the arm's reach"),
    ),
    "no_room_to_grasp": Why(
        Obstruction.RETRIEVAL,
        {"target"},
        "blocked",
        {"left_brick", "right_brick"},
        (
            "the immovable left_brick and the immovable right_brick are in the way",
            "no room for the hand",
        ),
    ),
    "too_wide": Why(
        Obstruction.RETRIEVAL,
        {"target"},
        "gripper_too_small",
        set(),
        ("no way was found to take out target", "the gripper does not open wide enough"),
    ),
    "behind_a_bar": Why(
        Obstruction.RETRIEVAL,
        {"target"},
        "blocked",
        {"bar"},
        ("no way was found to take out target", "the fixture bar is in the way"),
    ),
    "wedged": Why(
        Obstruction.PATHS,
        {"crate"},
        NO_WAY,
        {"left_board", "right_board", "target"},
        ("crate cannot get out of the way", "around it: the immovable left_board"),
    ),
    "no_free_place": Why(
        Obstruction.PATHS,
        {"plank"},
        NO_GOAL,
        set(),
        ("plank cannot get out of the way", NO_GOAL),
    ),
    "jammed": Why(
        Obstruction.PATHS,
        {"blue_crate", "red_crate"},
        "no_paths_found",
        {"blue_crate", "red_crate"},
        ("blue_crate and red_crate cannot get out of the way", "no paths for all of them"),
    ),
    "too_heavy": Why(
        Obstruction.ACTION,
        {"anvil"},
        "stalled",
        set(),
        ("anvil stands in the way", "with push the arm stalls"),
    ),
    "tips_over": Why(
        Obstruction.ACTION,
        {"tower"},
        "tilt",
        set(),
        ("tower stands in the way", "with push it tips over"),
    ),
    "into_glass": Why(
        Obstruction.ACTION,
        {"plank"},
        "contact",
        {"left_glass", "right_glass"},
        ("plank stands in the way", "the immovable left_glass or the immovable right_glass"),
    ),
}


@pytest.fixture(scope="module")
def registry():
    return discover()


def test_every_scene_is_tested():
    assert {path.stem for path in FOLDER.glob("*.yaml")} == set(WHY)


@pytest.mark.parametrize("name", WHY)
def test_the_headline_names_what_stands_in_the_way(name, registry):
    problem = load_problem(FOLDER / f"{name}.yaml")
    assert problem.name == name
    planner = compose(chosen_recipe("default", None, SETTINGS), problem, registry)
    solution = planner.solve(SECONDS, 0)
    assert solution.plan is None
    assert solution.reason != "no plan within the budget"
    explanation = explain(problem, solution, planner.diagnose(solution))
    expected = WHY[name]
    assert explanation.obstruction is expected.obstruction, explanation.headline
    assert set(explanation.subjects) == expected.subjects
    assert explanation.causes[0] == expected.cause
    assert set(explanation.involved) == expected.involved
    for words in expected.words:
        assert words in explanation.headline
    counted = solution.statistics.causes
    assert {f"{d.subject}/{d.action}/{d.cause}" for d in explanation.details} >= set(+counted)


def without(problem, *names):
    scene = problem.scene
    kept = [i for i, item in enumerate(scene.objects) if item.name not in names]
    fewer = replace(
        scene,
        objects=tuple(scene.objects[i] for i in kept),
        fixtures=tuple(f for f in scene.fixtures if f.name not in names),
    )
    initial = replace(problem.initial, object_poses=problem.initial.object_poses[kept])
    return replace(problem, scene=fewer, initial=initial)


def lighter(problem, name):
    objects = [replace(o, mass=0.3) if o.name == name else o for o in problem.scene.objects]
    return replace(problem, scene=replace(problem.scene, objects=tuple(objects)))


CURES = {
    "walled_in": lambda problem: without(problem, "gate"),
    "no_room_to_grasp": lambda problem: without(problem, "left_brick", "right_brick"),
    "behind_a_bar": lambda problem: without(problem, "bar"),
    "wedged": lambda problem: without(problem, "left_board", "right_board"),
    "jammed": lambda problem: without(problem, "blue_crate"),
    "into_glass": lambda problem: without(problem, "left_glass", "right_glass"),
    "too_heavy": lambda problem: lighter(problem, "anvil"),
    "tips_over": lambda problem: replace(problem, constraints=DEFAULT_CONSTRAINTS),
}


@pytest.mark.parametrize("name", CURES)
def test_it_was_the_reason(name, registry):
    """Without what the headline names there is a plan."""
    cured = CURES[name](load_problem(FOLDER / f"{name}.yaml"))
    solution = compose(chosen_recipe("default"), cured, registry).solve(SECONDS, 0)
    assert solution.plan is not None
