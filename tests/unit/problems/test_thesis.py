from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mamo_core.errors import InputError
from mamo_core.problems import import_file, load_problem
from mamo_core.problems.thesis import parse_raw
from mamo_core.types.geometry import Box, Cylinder, yaw_of
from mamo_core.types.scene import MINIMUM_MASS, Mobility

RAW = """O
8
1,0,-1,0.78,-0.5,0.75,0,0,0,0.3,0.4,0.02,0,0.8,False
2,0,-1,1.1,-0.5,0.93,0,0,0,0.02,0.4,0.2,0,0.8,False
3,0,-1,0.78,-0.5,1.11,0,0,0,0.3,0.4,0.02,0,0.8,False
4,0,-1,0.8,-0.92,0.93,0,0,0,0.32,0.02,0.2,0,0.8,False
5,0,-1,0.8,-0.08,0.93,0,0,0,0.32,0.02,0.2,0,0.8,False
6,0,0,0.9,-0.3,0.86,0,0,0.5,0.03,0.04,0.09,0.25,0.9,False
7,2,0,0.7,-0.6,0.845,0,0,0.25,0.03,0.03,0.15,0.01,1.1,False
8,2,1,0.6,-0.3,0.85,0,0,1.0,0.05,0.05,0.16,0.3,1.0,True
R
0,0,0,0,0,0,1
G
0.6,-0.6,0.845,0.1,-0,0
ooi
7
"""


@pytest.fixture
def raw_file(tmp_path: Path) -> Path:
    path = tmp_path / "plan_000042_SCENE.txt"
    path.write_text(RAW)
    return path


def test_a_raw_scene(raw_file: Path) -> None:
    (problem,), warnings = import_file(raw_file)
    assert problem.name == "thesis_42"
    scene = problem.scene
    assert [f.name for f in scene.fixtures] == ["base", "back", "top", "right", "left"]
    assert {f.friction for f in scene.fixtures} == {1.0}
    box, target, can = scene.objects
    assert [o.name for o in scene.objects] == ["o6", "o7", "o8"]
    assert [o.mobility for o in scene.objects] == [
        Mobility.IMMOVABLE,
        Mobility.TARGET,
        Mobility.MOVABLE,
    ]
    assert isinstance(box.shape, Box)
    np.testing.assert_allclose(box.shape.size, [0.06, 0.08, 0.18])
    assert can.shape == Cylinder(0.05, 0.16)
    assert (can.mass, can.friction) == (0.3, 1.0)
    assert target.mass == MINIMUM_MASS
    assert warnings == ["thesis_42: object 'o7' weighs 10 g; raised to 20 g"]
    np.testing.assert_allclose(scene.fixtures[0].shape.size, [0.6, 0.8, 0.04])  # type: ignore[union-attr]


def test_the_authors_grasp_comes_first(raw_file: Path) -> None:
    problem = load_problem(raw_file)
    target = problem.initial.object_poses[problem.scene.target_index]
    yaw = yaw_of(problem.grasps[0].T_object_tool) + yaw_of(target)
    assert yaw == pytest.approx(0.1)


def test_roll_pi_is_the_other_euler_twin() -> None:
    text = RAW.replace("0.845,0.1,-0,0", "0.845,-3.04159265,3.14159265,3.14159265")
    assert parse_raw(text, 0, "here").pregrasp.yaw == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("ooi\n7", "ooi\n9", r"here:16: ooi 9 is no immovable object .*\(valid: 6, 7\)"),
        ("ooi\n7", "", "section 'ooi' is missing; is the file cut short"),
        ("6,0,0,0.9", "6,1,0,0.9", r"here:8: shape 1, expected 0 \(box\) or 2 \(cylinder\)"),
        ("6,0,0,0.9", "6,0,5,0.9", "here:8: type 5, expected -1"),
        ("6,0,0,0.9", "6,0,0,nan", "here:8: 'nan', expected a finite number"),
        ("6,0,0,0.9", "6,0,0,x", "here:8: 'x', expected a finite number"),
        ("6,0,0,0.9,", "6,0,0,", "here:8: 14 values, expected 15"),
        ("5,0,-1", "9,0,-1", "here:7: shelf board 9, expected 1 to 5"),
        ("O\n8", "O\n80", "here:11: 1 values, expected 15"),
    ],
)
def test_damage_is_named_by_line(old: str, new: str, message: str) -> None:
    assert old in RAW
    with pytest.raises(InputError, match=message):
        parse_raw(RAW.replace(old, new, 1), 0, "here")


def test_a_file_cut_short(tmp_path: Path) -> None:
    path = tmp_path / "plan_1_SCENE.txt"
    path.write_text("\n".join(RAW.splitlines()[:6]))
    with pytest.raises(InputError, match="cut short"):
        load_problem(path)


def test_bad_values_are_refused_like_in_our_own_files(tmp_path: Path) -> None:
    path = tmp_path / "plan_1_SCENE.txt"
    path.write_text(RAW.replace("8,2,1,0.6,-0.3", "8,2,1,0.68,-0.58"))
    with pytest.raises(InputError, match="objects 'o7' and 'o8' overlap by"):
        load_problem(path)
    path.write_text(RAW.replace("0.16,0.3,1.0,True", "0.16,-0.3,1.0,True"))
    with pytest.raises(InputError, match=r"SCENE\.txt:10: mass: -0\.3, expected a number above 0"):
        load_problem(path)


@pytest.mark.scenes
@pytest.mark.parametrize(("movables", "count"), [(0, 99), (5, 88), (10, 89), (15, 101)])
def test_all_published_scenes_are_valid(scenes_folder: Path, movables: int, count: int) -> None:
    problems, warnings = import_file(scenes_folder / f"thesis_{movables}_movables.jsonl.gz")
    assert len(problems) == count
    assert warnings
    for problem in problems:
        assert len(problem.scene.movable_indices) == movables
        assert len(problem.scene.objects) == movables + 5
    # A few targets are wider than the gripper of our arm model opens.
    assert sum(not problem.grasps for problem in problems) < 0.1 * count


@pytest.mark.scenes
def test_both_formats_give_the_same_problem(scenes_folder: Path) -> None:
    raw = load_problem(scenes_folder / "example_SCENE.txt")
    line = load_problem(f"{scenes_folder / 'thesis_5_movables.jsonl.gz'}#100000")
    assert [o.name for o in raw.scene.objects] == [o.name for o in line.scene.objects]
    np.testing.assert_allclose(raw.initial.object_poses, line.initial.object_poses, atol=1e-6)
    for a, b in zip(raw.grasps, line.grasps, strict=True):
        np.testing.assert_allclose(a.T_object_tool, b.T_object_tool, atol=1e-6)
