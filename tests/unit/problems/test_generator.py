from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mamo_core.errors import InputError
from mamo_core.problems import generate_shelf, import_file, problem_document
from mamo_core.problems.checks import complaints
from mamo_core.problems.footprints import footprint, separation
from mamo_core.problems.generator import level_of
from mamo_core.types.geometry import Box
from mamo_core.types.problem import Problem
from mamo_core.types.scene import Mobility


def in_front(problem: Problem) -> int:
    """A stand-in for the NGR: the movables between the target and the open side."""
    target = problem.initial.object_poses[problem.scene.target_index]
    poses = problem.initial.object_poses[list(problem.scene.movable_indices)]
    near = np.abs(poses[:, 1] - target[1]) < 0.15
    return int((near & (poses[:, 0] < target[0])).sum())


def test_the_same_seed_gives_the_same_problem() -> None:
    one, two = (generate_shelf(movables=10, seed=4) for _ in range(2))
    other = generate_shelf(movables=10, seed=5)
    assert problem_document(one) == problem_document(two)
    assert problem_document(one) != problem_document(other)
    assert one.name == "shelf_10_seed4"


@pytest.mark.parametrize("movables", [0, 5, 10, 15])
def test_scenes_are_valid_and_as_asked_for(movables: int) -> None:
    for seed in range(5):
        problem = generate_shelf(movables=movables, seed=seed)
        assert complaints(problem) == []
        kinds = [item.mobility for item in problem.scene.objects]
        assert kinds.count(Mobility.MOVABLE) == movables
        assert kinds.count(Mobility.IMMOVABLE) == 4
        assert problem.grasps


def test_objects_keep_a_centimetre_apart() -> None:
    for seed in range(5):
        problem = generate_shelf(movables=15, seed=seed)
        pairs = zip(problem.scene.objects, problem.initial.object_poses, strict=True)
        outlines = [footprint(item.shape, pose) for item, pose in pairs]
        gaps = [separation(a, b).distance for i, a in enumerate(outlines) for b in outlines[:i]]
        assert min(gaps) >= 0.01


@pytest.mark.parametrize(
    ("level", "counts"), [("easy", {1}), ("medium", {2}), ("hard", {3, 4, 5, 6})]
)
def test_levels(level: str, counts: set[int]) -> None:
    problem = generate_shelf(movables=10, seed=2, level=level, classify=in_front)
    assert problem.name == f"shelf_10_{level}_seed2"
    assert in_front(problem) in counts
    again = generate_shelf(movables=10, seed=2, level=level, classify=in_front)
    assert problem_document(problem) == problem_document(again)


def test_level_of() -> None:
    assert [level_of(n) for n in range(5)] == [None, "easy", "medium", "hard", "hard"]


def test_scenes_without_any_retrieval_are_drawn_anew() -> None:
    seen: list[Problem] = []

    def classify(problem: Problem) -> int | None:
        seen.append(problem)
        return None if len(seen) < 3 else 0

    assert generate_shelf(movables=2, seed=0, classify=classify) is seen[2]


def test_giving_up_says_what_was_found() -> None:
    with pytest.raises(InputError) as caught:
        generate_shelf(
            movables=2,
            seed=0,
            level="hard",
            classify=lambda p: None if p.initial.object_poses[0, 0] > 0.7 else 1,
            max_draws=20,
        )
    text = str(caught.value)
    assert text.startswith("shelf_2_hard_seed0: none of 20 scenes fits (movables in the way")
    assert "target out of reach x" in text
    assert "1 x" in text


def test_bad_requests() -> None:
    with pytest.raises(InputError, match=r"level 'meduim'.*did you mean 'medium'"):
        generate_shelf(movables=5, seed=0, level="meduim", classify=in_front)
    with pytest.raises(InputError, match="movables: -1, expected 0 or more"):
        generate_shelf(movables=-1, seed=0)
    with pytest.raises(InputError, match="seed: -1"):
        generate_shelf(movables=1, seed=-1)
    with pytest.raises(InputError, match="no room for 500 movables"):
        generate_shelf(movables=500, seed=0)


def sizes(problems: list[Problem]) -> dict[str, np.ndarray]:
    items = [item for p in problems for item in p.scene.objects]
    poses = np.concatenate([p.initial.object_poses for p in problems])
    boxes = [item for item in items if isinstance(item.shape, Box)]
    round_ones = [item.shape for item in items if not isinstance(item.shape, Box)]
    return {
        "box half x": np.array([item.shape.size[0] / 2 for item in boxes]),  # type: ignore[union-attr]
        "box half height": np.array([item.shape.height / 2 for item in boxes]),
        "radius": np.array([shape.radius for shape in round_ones]),  # type: ignore[union-attr]
        "cylinder height": np.array([shape.height for shape in round_ones]),
        "mass": np.array([item.mass for item in items]),
        "friction": np.array([item.friction for item in items]),
        "x": poses[:, 0],
        "y": poses[:, 1],
    }


TOLERANCES = {
    "box half x": 0.012,
    "box half height": 0.012,
    "radius": 0.016,
    "cylinder height": 0.010,
    "mass": 0.04,
    "friction": 0.03,
    "x": 0.04,
    "y": 0.05,
}
"""How far quartiles may lie apart; the published objects are a little smaller, since scenes
without a possible retrieval were left out."""


@pytest.mark.scenes
@pytest.mark.parametrize("movables", [5, 15])
def test_the_published_marginals_are_met(scenes_folder: Path, movables: int) -> None:
    published, _ = import_file(scenes_folder / f"thesis_{movables}_movables.jsonl.gz")
    ours = [generate_shelf(movables=movables, seed=seed) for seed in range(len(published))]
    theirs, mine = sizes(published), sizes(ours)
    for name, tolerance in TOLERANCES.items():
        for quantile in (0.25, 0.5, 0.75):
            a, b = np.quantile(theirs[name], quantile), np.quantile(mine[name], quantile)
            assert abs(a - b) < tolerance, f"{name}, quantile {quantile}: {a:.4f} and {b:.4f}"
    share = [len(s["radius"]) / len(s["mass"]) for s in (theirs, mine)]
    assert abs(share[0] - share[1]) < 0.08
