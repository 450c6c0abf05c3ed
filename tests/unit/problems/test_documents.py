from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mamo_core.errors import InputError
from mamo_core.problems import load_problem, problem_document, problem_from_document, problem_schema
from mamo_core.types.geometry import pose_from_matrix, tool_matrix
from mamo_core.types.problem import ConstraintSpec, Grasp, Problem, Task
from mamo_core.types.scene import SceneState

Edit = Callable[..., dict[str, object]]


def same_problem(a: Problem, b: Problem) -> bool:
    return problem_document(a) == problem_document(b) and all(
        np.array_equal(x, y)
        for x, y in [
            (a.initial.object_poses, b.initial.object_poses),
            (a.initial.joint_positions, b.initial.joint_positions),
            *((g.T_object_tool, h.T_object_tool) for g, h in zip(a.grasps, b.grasps, strict=True)),
        ]
    )


def test_round_trip_is_exact(shelf: Problem) -> None:
    document = problem_document(shelf)
    assert document["grasps"] == "auto"
    assert same_problem(shelf, problem_from_document(document, "here"))


def test_round_trip_of_unusual_poses_grasps_and_constraints(shelf: Problem) -> None:
    pose = pose_from_matrix(tool_matrix([0.01, 0.02, 0.03], 0.4, pitch=0.3))
    poses = np.array(shelf.initial.object_poses)
    poses[0, 3:] = -poses[0, 3:]
    unusual = replace(
        shelf,
        grasps=(Grasp(pose, 0.12, 0.07),),
        initial=SceneState(shelf.initial.joint_positions, poses),
        constraints=(ConstraintSpec("tilt", {"limit_deg": 30.0}), ConstraintSpec("contact")),
    )
    back = problem_from_document(problem_document(unusual), "here")
    assert same_problem(unusual, back)
    assert [(c.name, dict(c.options)) for c in back.constraints] == [
        ("tilt", {"limit_deg": 30.0}),
        ("contact", {}),
    ]


def test_round_trip_of_a_reach(shelf: Problem) -> None:
    reach = replace(shelf, task=Task.REACH, grasps=shelf.grasps[3:4])
    document = problem_document(reach)
    assert document["task"] == "reach"
    assert document["grasps"][0]["opening"] == shelf.grasps[3].opening
    back = problem_from_document(document, "here")
    assert back.task is Task.REACH
    assert same_problem(reach, back)


def test_the_task_is_to_retrieve_unless_said_otherwise(shelf: Problem, edited: Edit) -> None:
    assert "task" not in problem_document(shelf)
    assert problem_from_document(problem_document(shelf), "here").task is Task.RETRIEVE
    assert problem_from_document(edited("task", value="retrieve"), "here").task is Task.RETRIEVE
    with pytest.raises(InputError, match="task: 'grab', expected 'retrieve' or 'reach'"):
        problem_from_document(edited("task", value="grab"), "here")


def test_a_rounded_quaternion_is_made_unit(edited: Edit) -> None:
    document = edited(
        "robot", "base", value={"position": [0, 0, 0], "quat_wxyz": [0.70711, 0, 0, 0.70711]}
    )
    base = problem_from_document(document, "here").scene.T_world_base
    assert np.linalg.norm(base[3:]) == pytest.approx(1.0, abs=1e-15)


def test_home_defaults_to_the_start(edited: Edit) -> None:
    problem = problem_from_document(edited("robot", "home", value=None), "here")
    assert np.array_equal(problem.home, problem.initial.joint_positions)


def test_schema_describes_the_document() -> None:
    schema = problem_schema()
    assert {"objects", "target", "robot", "grasps"} <= set(schema["properties"])


@pytest.mark.parametrize(
    ("keys", "value", "message"),
    [
        (("target",), "o66", r"target: no object 'o66' in the scene; did you mean 'o6'\?.*o13"),
        (("objects", 0, "name"), "o7", r"name 'o7' is already that of objects\.0"),
        (("objects", 0, "name"), "base", r"name 'base' is already that of objects\.0"),
        (("objects", 0, "name"), "robot", "name 'robot' is already that of the robot"),
        (("objects", 0, "mass"), float("nan"), "objects.0.mass: nan, expected a finite number"),
        (("objects", 0, "mass"), -1.0, "objects.0.mass: -1.0, expected a number above 0"),
        (("objects", 0, "mass"), "heavy", "objects.0.mass: 'heavy', expected a number"),
        (("objects", 0, "friction"), 0, "objects.0.friction: 0, expected a number above 0"),
        (("objects", 0, "mobility"), "sticky", "expected 'movable' or 'immovable'"),
        (("objects", 0, "position"), [0.7, -0.5], "objects.0.position: 2 items"),
        (("schema_version",), 2, "schema_version: 2, expected 1"),
        (("robot", "name"), "pr3", "robot 'pr3' is not known.*panda, pr2_right_arm"),
        (("robot", "home"), [0.0], "home has 1 joints, the initial configuration 7"),
        (("workspace", "lower"), [0.48, 0.9, 0.77], "lower .* must be below upper"),
        (("colour",), "red", "unknown key 'colour'"),
    ],
)
def test_mistakes_are_named(
    edited: Edit, keys: tuple[str | int, ...], value: object, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        problem_from_document(edited(*keys, value=value), "here")


def target_place(shelf: Problem) -> int:
    return shelf.scene.target_index


def test_the_target_has_no_mobility(shelf: Problem, edited: Edit) -> None:
    document = edited("objects", target_place(shelf), "mobility", value="movable")
    with pytest.raises(InputError, match="is the target, expected no mobility"):
        problem_from_document(document, "here")


def test_one_shape_and_one_orientation(edited: Edit) -> None:
    for key, value, message in (
        ("quat_wxyz", [1, 0, 0, 0], "expected 'yaw' or 'quat_wxyz', not both"),
        ("yaw", None, "ok"),
    ):
        document = edited("objects", 0, key, value=value)
        if message == "ok":
            problem_from_document(document, "here")
            continue
        with pytest.raises(InputError, match=message):
            problem_from_document(document, "here")
    both = edited("objects", 0, "box", value=[0.06, 0.06, 0.2])
    both["objects"][0]["cylinder"] = {"radius": 0.03, "height": 0.2}  # type: ignore[index]
    with pytest.raises(InputError, match="expected either 'box' or 'cylinder'"):
        problem_from_document(both, "here")


def test_quaternions_must_have_length_one(edited: Edit) -> None:
    value = {"position": [0, 0, 0], "quat_wxyz": [1, 1, 0, 0]}
    with pytest.raises(InputError, match=r"quat_wxyz has length 1\.414, expected 1"):
        problem_from_document(edited("robot", "base", value=value), "here")


class TestPlacement:
    """Complaints about where things stand name the object, how far off, and the place."""

    def moved(self, text: str, name: str, position: str, tmp_path: Path) -> Path:
        path = tmp_path / "moved.yaml"
        pattern = rf"(name: {name}\n(?:  .*\n)*?  position: )\[.*\]"
        changed, count = re.subn(pattern, rf"\g<1>{position}", text)
        assert count == 1
        path.write_text(changed)
        return path

    def complaint(self, path: Path) -> str:
        with pytest.raises(InputError) as caught:
            load_problem(path)
        return str(caught.value)

    def test_overlap(self, shelf: Problem, yaml_text: str, tmp_path: Path) -> None:
        first, second = shelf.scene.objects[:2]
        x, y, z = shelf.initial.object_poses[0, :3]
        z += (second.shape.height - first.shape.height) / 2
        path = self.moved(yaml_text, second.name, f"[{x}, {y}, {z:.7f}]", tmp_path)
        text = self.complaint(path)
        assert f"objects '{first.name}' and '{second.name}' overlap by" in text
        assert "mm, expected at most 1 mm" in text
        line, column = (int(part) for part in text.removeprefix(f"{path}:").split(":")[:2])
        assert path.read_text().splitlines()[line - 1][column - 1 :].startswith(f"[{x}, {y}")

    def test_below_and_above_the_floor(
        self, shelf: Problem, yaml_text: str, tmp_path: Path
    ) -> None:
        x, y, z = shelf.initial.object_poses[0, :3]
        for shift, side in ((-0.02, "below"), (0.02, "above")):
            path = self.moved(yaml_text, "o6", f"[{x}, {y}, {z + shift:.6f}]", tmp_path)
            assert f"{side} the floor; expected 0.77 m (position z = " in self.complaint(path)

    def test_outside_and_inside_a_wall(
        self, shelf: Problem, yaml_text: str, tmp_path: Path
    ) -> None:
        x, _, z = shelf.initial.object_poses[0, :3]
        text = self.complaint(self.moved(yaml_text, "o6", f"[{x}, -0.1, {z}]", tmp_path))
        assert "object 'o6' covers x" in text
        assert "outside the workspace x 0.430..1.080, y -0.900..-0.100 m" in text
        assert "mm inside fixture 'left'" in text

    def test_tilted(self, edited: Edit) -> None:
        document = edited("objects", 0, "quat_wxyz", value=[0.5**0.5, 0.5**0.5, 0, 0])
        del document["objects"][0]["yaw"]  # type: ignore[index]
        with pytest.raises(InputError, match=r"is tilted by 1\.57 rad, expected upright"):
            problem_from_document(document, "here")

    def test_too_tall(self, edited: Edit) -> None:
        document = edited("objects", 0, "cylinder", value={"radius": 0.03, "height": 0.4})
        document["objects"][0].pop("box", None)  # type: ignore[index]
        document["objects"][0]["position"][2] = 0.97  # type: ignore[index]
        with pytest.raises(InputError, match=r"reaches up to z = 1\.170 m, above"):
            problem_from_document(document, "here")

    def test_in_a_ramp(self, shelf: Problem, edited: Edit) -> None:
        x, y, _ = shelf.initial.object_poses[0, :3].tolist()
        document = edited("fixtures", 0, "name", value="base")
        ramp = {
            "name": "ramp",
            "box": [0.2, 0.2, 0.02],
            "position": [x, y, 0.80],
            "quat_wxyz": [np.cos(0.2), np.sin(0.2), 0.0, 0.0],
        }
        document["fixtures"].append(ramp)  # type: ignore[attr-defined]
        with pytest.raises(InputError, match=r"object 'o6' is .* mm inside fixture 'ramp'"):
            problem_from_document(document, "here")
