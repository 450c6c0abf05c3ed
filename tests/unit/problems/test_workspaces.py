"""Seeded reaches on the table and in the refrigerator of thesis chapter 3."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from mamo_core.errors import InputError
from mamo_core.problems import (
    generate_workspace,
    problem_document,
    problem_from_document,
)
from mamo_core.problems.checks import complaints
from mamo_core.problems.footprints import extents, footprint, separation
from mamo_core.problems.layouts import LAYOUTS
from mamo_core.problems.ycb import CATALOGUE
from mamo_core.robots.grasps import hand_of, widths_between_fingers
from mamo_core.types.geometry import matrix_from_pose
from mamo_core.types.problem import Problem, Task
from mamo_core.types.scene import Mobility

Generate = Callable[..., Problem]
tabletop = partial(generate_workspace, "tabletop")
refrigerator = partial(generate_workspace, "refrigerator")
BOTH = pytest.mark.parametrize("generate", [tabletop, refrigerator])


@BOTH
def test_the_same_seed_gives_the_same_problem(generate: Generate) -> None:
    one, two, other = (generate(seed=seed) for seed in (4, 4, 5))
    assert problem_document(one) == problem_document(two)
    assert problem_document(one)["objects"] != problem_document(other)["objects"]


def test_names_tell_workspace_numbers_and_seed() -> None:
    assert tabletop(seed=4).name == "tabletop_6_6_seed4"
    assert tabletop(seed=4, movables=8).name == "tabletop_8_6_seed4"
    assert refrigerator(seed=4, immovables=1).name == "refrigerator_3_1_seed4"


@pytest.mark.parametrize(
    ("workspace", "movables", "immovables"),
    [("tabletop", 6, 6), ("tabletop", 8, 6), ("tabletop", 0, 1), ("refrigerator", 3, 2)],
)
def test_scenes_are_valid_and_as_asked_for(workspace: str, movables: int, immovables: int) -> None:
    for seed in range(5):
        problem = generate_workspace(workspace, seed=seed, movables=movables, immovables=immovables)
        assert complaints(problem) == []
        kinds = [item.mobility for item in problem.scene.objects]
        assert kinds.count(Mobility.MOVABLE) == movables
        assert kinds.count(Mobility.IMMOVABLE) == immovables - 1
        assert kinds.count(Mobility.TARGET) == 1


@BOTH
def test_numbers_default_to_those_of_the_thesis(generate: Generate) -> None:
    kinds = [item.mobility for item in generate(seed=0).scene.objects]
    expected = {tabletop: (6, 6), refrigerator: (3, 2)}[generate]
    movables = kinds.count(Mobility.MOVABLE)
    assert (movables, len(kinds) - movables) == expected


@BOTH
def test_objects_are_those_of_the_set_with_drawn_friction(generate: Generate) -> None:
    known = {item.name: item for item in CATALOGUE}
    frictions = []
    for seed in range(10):
        for item in generate(seed=seed).scene.objects:
            original = known[item.name.rstrip("_0123456789")]
            assert (item.shape, item.mass) == (original.shape, original.mass)
            frictions.append(item.friction)
    assert 0.5 <= min(frictions) < 0.6
    assert 1.0 < max(frictions) <= 1.1


@BOTH
def test_objects_stand_apart_and_within(generate: Generate) -> None:
    for seed in range(10):
        problem = generate(seed=seed)
        pairs = zip(problem.scene.objects, problem.initial.object_poses, strict=True)
        outlines = [footprint(item.shape, pose) for item, pose in pairs]
        gaps = [separation(a, b).distance for i, a in enumerate(outlines) for b in outlines[:i]]
        assert min(gaps) >= 0.01
        boxes = np.array([extents(outline) for outline in outlines])
        space = problem.scene.workspace
        wall = LAYOUTS[problem.name.split("_")[0]].gap
        assert (boxes[:, :2] >= space.lower[:2] + np.array([0.0, wall])).all()
        assert (boxes[:, 2:] <= space.upper[:2] - wall).all()


@BOTH
def test_the_goal_is_one_pre_grasp_that_fits_and_comes_from_the_front(generate: Generate) -> None:
    for seed in range(10):
        problem = generate(seed=seed)
        (grasp,) = problem.grasps
        assert problem.task is Task.REACH
        target = problem.scene.objects[problem.scene.target_index]
        T_object_tool = matrix_from_pose(grasp.T_object_tool)[None]
        width = widths_between_fingers(target.shape, T_object_tool)[0]
        assert width < grasp.opening <= hand_of(problem.scene.robot).opening
        assert problem.pregrasps[0][0, 0] >= 0.0


@BOTH
def test_documents_give_back_the_same(generate: Generate) -> None:
    problem = generate(seed=3)
    document = problem_document(problem)
    assert document["task"] == "reach"
    back = problem_from_document(document, "here")
    assert problem_document(back) == document
    assert np.array_equal(back.pregrasps, problem.pregrasps)


def test_scenes_out_of_reach_are_drawn_anew() -> None:
    seen: list[Problem] = []

    def classify(problem: Problem) -> int | None:
        seen.append(problem)
        return None if len(seen) < 3 else 4

    assert tabletop(seed=0, classify=classify) is seen[2]


def test_giving_up_says_what_was_found() -> None:
    with pytest.raises(InputError) as caught:
        refrigerator(seed=0, classify=lambda problem: None, max_draws=3)
    assert str(caught.value) == (
        "refrigerator_3_2_seed0: none of 3 scenes fits (movables in the way, by scene: target out "
        "of reach x3); try another seed or number of movables"
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"movables": -1}, "movables: -1, expected 0 or more"),
        ({"immovables": 0}, "immovables: 0, expected 1 or more"),
        ({"seed": -1}, "seed: -1, expected 0 or more"),
        ({"movables": 90}, "no room for 90 movables and 6 immovables in 20 attempts"),
    ],
)
def test_bad_requests(arguments: dict[str, int], message: str) -> None:
    with pytest.raises(InputError, match=message):
        tabletop(**{"seed": 0, **arguments})


def test_an_unknown_workspace() -> None:
    with pytest.raises(InputError, match=r"workspace 'tabeltop' is not known.*'tabletop'"):
        generate_workspace("tabeltop", seed=0)
