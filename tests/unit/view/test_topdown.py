from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mamo_core.problems import generate_shelf, generate_workspace
from mamo_core.testing.transition_cases import gantry_cases
from mamo_core.types.action import RearrangementAction
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Plan
from mamo_core.view.topdown import GOAL, WALL, _title, draw


@pytest.fixture(scope="module")
def problem() -> Problem:
    return generate_shelf(movables=4, seed=0)


def plan_for(problem: Problem, *, region: bool) -> Plan:
    motion = gantry_cases().push
    place = problem.scene.movable_indices[0]
    start = problem.initial.object_poses[place, :2]
    name = problem.scene.objects[place].name
    actions = (
        RearrangementAction("push", name, motion, np.array([start, start + np.array([0.0, 0.1])])),
        RearrangementAction("push", name, motion, np.array([start])),
    )
    lowest = np.full((20, 20), np.inf)
    lowest[:10, 5:15] = 0.8
    swept = SweptRegion(np.array([0.43, -0.6]), 0.01, lowest, 0.77)
    return Plan(actions, motion, swept if region else None)


def pixels(path: Path) -> np.ndarray:
    from matplotlib.image import imread

    return (imread(path)[:, :, :3] * 255).round().astype(int)


def has_color(image: np.ndarray, color: str, least: int = 200) -> bool:
    rgb = [int(color[i : i + 2], 16) for i in (1, 3, 5)]
    return int((np.abs(image - rgb).max(axis=2) <= 2).sum()) >= least


def test_a_problem_alone_is_one_panel(problem: Problem, tmp_path: Path) -> None:
    draw(problem, tmp_path / "p.png")
    height, width, _ = pixels(tmp_path / "p.png").shape
    assert 0.8 < width / height < 1.4


def test_a_plan_shows_region_paths_and_outcome(problem: Problem, tmp_path: Path) -> None:
    poses = np.array(problem.initial.object_poses)
    poses[problem.scene.movable_indices[0], 1] += 0.1
    poses[problem.scene.target_index, 0] -= 0.3
    final = SceneState(problem.home, poses)
    draw(problem, tmp_path / "p.png", plan=plan_for(problem, region=True), final_state=final)
    image = pixels(tmp_path / "p.png")
    assert image.shape[1] / image.shape[0] > 1.8
    assert has_color(image, "#b8b8b8", 2000), "the region"
    assert has_color(image, "#7a1f5c"), "the arrows"


def test_without_a_plan_there_are_no_arrows(problem: Problem, tmp_path: Path) -> None:
    draw(problem, tmp_path / "p.png")
    image = pixels(tmp_path / "p.png")
    assert not has_color(image, "#7a1f5c", 1)
    assert not has_color(image, "#b8b8b8", 2000)


def test_reaches(tmp_path: Path) -> None:
    reach = generate_workspace("tabletop", seed=0)
    draw(reach, tmp_path / "p.png")
    assert has_color(pixels(tmp_path / "p.png"), GOAL, 50), "the pre-grasp pose"
    assert not has_color(pixels(tmp_path / "p.png"), WALL, 2000), "a table has no walls"
    assert _title(reach, plan_for(reach, region=True)) == (
        "tabletop_6_6_seed0: 2 rearrangements, then the reach"
    )


def test_the_same_input_gives_the_same_picture(problem: Problem, tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        draw(problem, tmp_path / name, plan=plan_for(problem, region=False))
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_matplotlib_is_imported_only_to_draw() -> None:
    code = "import sys, mamo_core.view.topdown; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
