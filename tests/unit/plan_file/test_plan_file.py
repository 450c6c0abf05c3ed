"""Plan files: a true round trip, the same bytes twice, and complaints about broken ones."""

import json

import numpy as np
import pytest

from mamo_core.errors import InputError
from mamo_core.plan_file import (
    PlanDocument,
    in_problem,
    package_versions,
    plan_text,
    read_plan,
    write_plan,
)
from mamo_core.types.action import RearrangementAction
from mamo_core.types.geometry import Box, Cylinder, make_pose
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.problem import Grasp, Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility, Scene, SceneObject, SceneState, Workspace
from mamo_core.types.solution import Plan

DOF = 7


def make_problem(name="p", target="t", movable="o1", dof=DOF):
    objects = (
        SceneObject(target, Box([0.06, 0.06, 0.2]), Mobility.TARGET, 0.4, 0.5),
        SceneObject(movable, Cylinder(0.03, 0.1), Mobility.MOVABLE, 0.3, 0.6),
    )
    scene = Scene(
        robot="pr2_right_arm",
        T_world_base=make_pose([0, 0, 0]),
        fixtures=(),
        objects=objects,
        workspace=Workspace([0, -0.5, 0.0], [1, 0.5, 1.0]),
    )
    poses = np.array([make_pose([0.5, 0.1, 0.1], 0.3), make_pose([0.4, -0.1, 0.05])])
    state = SceneState(np.zeros(dof), poses)
    grasp = Grasp(make_pose([-0.1, 0, 0]), 0.1, 0.07)
    return Problem(name, scene, state, np.zeros(dof), (grasp,))


def make_motion(rng, held=None):
    first, second = rng.random((3, DOF)), rng.random((2, DOF))
    second[0] = first[-1]
    go = Trajectory([0, 0.1, 1 / 3], first, rng.random((3, DOF)))
    carry = Trajectory([0, 0.2], second, rng.random((2, DOF)))
    segments = (
        MotionSegment(SegmentKind.TRANSIT, go, 0.01, None, True),
        MotionSegment(SegmentKind.CARRY, carry, 0.07, held, False, 0.5, closes_on=held),
    )
    return Motion(segments, 0.02)


def make_document(**changes):
    rng = np.random.default_rng(0)
    info = {"yaw": np.float64(0.5), "cells": np.arange(2), "note": ("a", None)}
    action = RearrangementAction("push", "o1", make_motion(rng), rng.random((4, 2)), info)
    plan = Plan((action,), make_motion(rng, "t"))
    values = {
        "problem": make_problem(),
        "plan": plan,
        "recipe": {"schema_version": 1, "name": "r", "backend": "toy"},
        "seed": 3,
        "margin": {"1 mm": 0.9, "5 mm": 1 / 3},
    }
    return PlanDocument(**{**values, **changes})


def same_motion(one, two):
    assert one.opening == two.opening
    for a, b in zip(one.segments, two.segments, strict=True):
        for name in ("kind", "opening", "held", "contact_free", "settle", "closes_on"):
            assert getattr(a, name) == getattr(b, name), name
        assert (a.trajectory.times == b.trajectory.times).all()
        assert (a.trajectory.positions == b.trajectory.positions).all()
        assert (a.trajectory.velocities == b.trajectory.velocities).all()


def test_round_trip_bit_for_bit(tmp_path):
    before = make_document()
    write_plan(tmp_path / "plan.json", before)
    after = read_plan(tmp_path / "plan.json")
    for one, two in zip(before.plan.motions, after.plan.motions, strict=True):
        same_motion(one, two)
    (action,) = after.plan.actions
    assert (action.kind, action.object_name) == ("push", "o1")
    assert (action.path == before.plan.actions[0].path).all()
    assert action.info == {"yaw": 0.5, "cells": [0, 1], "note": ["a", None]}
    initial = before.problem.initial.object_poses
    assert (after.problem.initial.object_poses == initial).all()
    assert after.recipe == before.recipe
    assert (after.seed, after.margin) == (3, {"1 mm": 0.9, "5 mm": 1 / 3})
    assert after.versions == package_versions()
    assert plan_text(after) == plan_text(before)


def test_the_text_is_sorted_json_without_times():
    data = json.loads(plan_text(make_document()))
    assert list(data) == sorted(data)
    assert data["schema_version"] == 2
    assert "seconds" not in data
    assert {"mamo", "numpy"} <= set(data["versions"])


def test_what_nobody_can_check_is_not_written():
    """The region that was cleared, and counts and causes of the search."""
    document = make_document()
    cleared = SweptRegion([0.1, 0.2], 0.01, np.zeros((3, 4)), 0.0)
    plan = Plan(document.plan.actions, document.plan.retrieval, cleared)
    assert plan_text(make_document(plan=plan)) == plan_text(document)
    assert not {"region", "counts", "causes"} & set(json.loads(plan_text(document)))


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "plan.json"
    write_plan(path, make_document())
    before = path.read_text()
    with pytest.raises(ValueError, match="JSON compliant"):
        write_plan(path, make_document(recipe={"x": float("nan")}))
    assert path.read_text() == before
    assert list(tmp_path.iterdir()) == [path]


def test_missing_folder(tmp_path):
    with pytest.raises(InputError, match="no such folder"):
        write_plan(tmp_path / "nowhere" / "plan.json", make_document())


def complaint(tmp_path, change):
    """What reading says of a plan file after ``change`` of its data, or of its text."""
    path = tmp_path / "plan.json"
    text = plan_text(make_document())
    data = json.loads(text)
    changed = change(data)
    path.write_text(changed if isinstance(changed, str) else json.dumps(data))
    with pytest.raises(InputError) as caught:
        read_plan(path)
    return str(caught.value).removeprefix(str(path))


def test_truncated(tmp_path):
    text = plan_text(make_document())
    message = complaint(tmp_path, lambda data: text[: len(text) // 2])
    assert "not valid YAML or JSON" in message
    assert "the end of the file" in message


def test_empty(tmp_path):
    assert complaint(tmp_path, lambda data: "") == ":1:1: the document is empty"


@pytest.mark.parametrize(
    ("path", "value", "expected"),
    [
        (["schema_version"], 1, "schema_version: 1, expected 2"),
        (["seed"], "3", "seed: '3', expected a whole number"),
        (["sead"], 3, "unknown key 'sead'; did you mean 'seed'?"),
        (["status"], "maybe", "status: 'maybe', expected 'solved'"),
        (["actions", 0, "kind"], 3, "actions.0.kind: 3, expected text"),
        (["actions", 0, "object"], "o9", "no objects ['o9'] in the problem (valid: ['t', 'o1'])"),
        (["retrieval", "segments", 1, "held"], "o9", "no objects ['o9'] in the problem"),
        (["retrieval", "segments", 0, "kind"], "fly", "kind: 'fly', expected 'transit'"),
        (["retrieval", "segments", 0, "times"], [0, 1], "trajectory: 2 times for 3 positions"),
        (["retrieval", "segments", 0, "positions", 1], [0.0], "expected rows of one length"),
        (["retrieval", "segments", 0, "times", 0], None, "times.0: null, expected a number"),
        (["retrieval", "segments"], [], "segments: [], expected at least 1 items, there are 0"),
        (["retrieval", "segments", 1, "closes_on"], "o9", "no objects ['o9'] in the problem"),
        (["margin", "1 mm"], "often", "margin.1 mm: 'often', expected a number"),
        (["region"], None, "unknown key 'region'"),
        (["problem", "target"], "o9", "'o9'"),
    ],
)
def test_wrong_content(tmp_path, path, value, expected):
    def change(data):
        *parents, last = path
        for key in parents:
            data = data[key]
        data[last] = value

    assert expected in complaint(tmp_path, change)


def test_wrong_number_of_joints(tmp_path):
    def change(data):
        for segment in data["retrieval"]["segments"]:
            for values in ("positions", "velocities"):
                segment[values] = [row[:3] for row in segment[values]]

    assert complaint(tmp_path, change).endswith("a trajectory of 3 joints, the robot has 7")


def test_in_a_problem_that_fits_the_plan_is_the_same():
    before, other = make_document(), make_problem(name="another")
    after = in_problem(before, other)
    assert after.problem is other
    assert after.plan is before.plan


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"movable": "o2"}, "no objects ['o1'] in the problem (valid: ['t', 'o2'])"),
        ({"target": "goal"}, "no objects ['t'] in the problem (valid: ['goal', 'o1'])"),
        ({"dof": 6}, "a trajectory of 7 joints, the robot has 6"),
    ],
)
def test_in_a_problem_that_does_not_fit(changes, expected):
    other = make_problem(name="another", **changes)
    with pytest.raises(InputError) as caught:
        in_problem(make_document(), other)
    assert str(caught.value) == f"problem 'another' does not fit the plan: {expected}"
