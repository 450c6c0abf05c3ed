"""Problems to and from documents of our own format (see ``schema``)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mamo_core.config import Located, validated
from mamo_core.errors import InputError, suggestion
from mamo_core.problems.checks import complaints
from mamo_core.problems.grasps import default_grasps
from mamo_core.problems.schema import (
    SCHEMA_VERSION,
    GraspEntry,
    ObjectEntry,
    PoseEntry,
    ProblemDocument,
)
from mamo_core.robots.grasps import hand_of
from mamo_core.robots.specs import SPECS
from mamo_core.types.geometry import Array, frozen_array, make_pose, shape_document, yaw_of
from mamo_core.types.problem import DEFAULT_CONSTRAINTS, ConstraintSpec, Grasp, Problem, Task
from mamo_core.types.scene import Fixture, Mobility, Scene, SceneObject, SceneState, Workspace


def problem_from_document(data: Mapping[str, Any], source: str) -> Problem:
    """The problem in plain data; ``source`` names their origin in complaints.

    Raises:
        InputError: the data are not a valid problem.
    """
    return problem_from_located(Located(dict(data), source))


def problem_from_located(located: Located) -> Problem:
    """The problem in a document that knows where everything stands.

    Raises:
        InputError: one line for each thing that is wrong, with its place.
    """
    document = validated(ProblemDocument, located)
    _check_names(document, located)
    robot = document.robot.name
    if robot not in SPECS:
        words = f"robot {robot!r} is not known{suggestion(robot, SPECS)}"
        raise located.error(words, ("robot", "name"))
    try:
        problem = _problem(document)
    except ValueError as error:
        raise located.error(str(error)) from error
    found = complaints(problem)
    if found:
        lines = [str(located.error(c.message, ("objects", c.place, "position"))) for c in found]
        raise InputError("\n".join(lines))
    return problem


def _check_names(document: ProblemDocument, located: Located) -> None:
    seen = {"robot": "the robot"}
    for kind, entries in (("objects", document.objects), ("fixtures", document.fixtures)):
        for i, entry in enumerate(entries):
            if entry.name in seen:
                message = f"name {entry.name!r} is already that of {seen[entry.name]}"
                raise located.error(message, (kind, i, "name"))
            seen[entry.name] = f"{kind}.{i}"
    names = [entry.name for entry in document.objects]
    if document.target not in names:
        raise located.error(
            f"target: no object {document.target!r} in the scene"
            f"{suggestion(document.target, names)}",
            ("target",),
        )
    place = names.index(document.target)
    if document.objects[place].mobility is not None:
        raise located.error(
            f"objects.{place}.mobility: {document.target!r} is the target, expected no mobility",
            ("objects", place, "mobility"),
        )


def _problem(document: ProblemDocument) -> Problem:
    objects = tuple(_object(entry, document.target) for entry in document.objects)
    poses = np.array([_pose(entry) for entry in document.objects])
    scene = Scene(
        robot=document.robot.name,
        T_world_base=_pose(document.robot.base),
        fixtures=tuple(
            Fixture(entry.name, entry.shape(), _pose(entry), entry.friction)
            for entry in document.fixtures
        ),
        objects=objects,
        workspace=_workspace(document),
    )
    joints = np.array(document.robot.joints)
    home = joints if document.robot.home is None else np.array(document.robot.home)
    return Problem(
        name=document.name,
        scene=scene,
        initial=SceneState(joints, poses),
        home=home,
        grasps=_grasps(document, scene, poses[scene.target_index]),
        constraints=_constraints(document),
        task=Task(document.task),
    )


def _object(entry: ObjectEntry, target: str) -> SceneObject:
    mobility = Mobility(entry.mobility or "movable")
    if entry.name == target:
        mobility = Mobility.TARGET
    return SceneObject(entry.name, entry.shape(), mobility, entry.mass, entry.friction)


def _workspace(document: ProblemDocument) -> Workspace:
    entry = document.workspace
    return Workspace(np.array(entry.lower), np.array(entry.upper), entry.overhang)


def _pose(entry: PoseEntry) -> Array:
    if entry.quat_wxyz is None:
        return make_pose(entry.position, entry.yaw or 0.0)
    quat = np.array(entry.quat_wxyz)
    norm = np.linalg.norm(quat)
    # Written poses come back bit for bit; only quaternions rounded by hand are mended.
    unit = quat if abs(norm - 1.0) < 1e-12 else quat / norm
    return frozen_array([*entry.position, *unit], "pose", (7,))


def _grasps(document: ProblemDocument, scene: Scene, pose: Array) -> tuple[Grasp, ...]:
    if document.grasps == "auto":
        return automatic_grasps(scene, pose)
    return tuple(_grasp(entry) for entry in document.grasps)


def automatic_grasps(scene: Scene, target_pose: Array) -> tuple[Grasp, ...]:
    """What ``grasps: auto`` stands for: side grasps, those that look into the shelf (+x) first.

    ``target_pose`` (7,): initial pose of the target, world.

    Raises:
        InputError: default grasps are not known for the robot.
    """
    return default_grasps(
        scene.objects[scene.target_index],
        hand_of(scene.robot),
        first_yaw=-yaw_of(target_pose),
    )


def _grasp(entry: GraspEntry) -> Grasp:
    return Grasp(_pose(entry), entry.approach, entry.opening)


def _constraints(document: ProblemDocument) -> tuple[ConstraintSpec, ...]:
    if document.constraints is None:
        return DEFAULT_CONSTRAINTS
    return tuple(ConstraintSpec(entry.name, entry.options) for entry in document.constraints)


def problem_document(problem: Problem) -> dict[str, Any]:
    """The problem as plain data; ``problem_from_document`` gives back the same, bit for bit."""
    scene = problem.scene
    document: dict[str, Any] = {
        "schema_version": SCHEMA_VERSION,
        "name": problem.name,
        "robot": {
            "name": scene.robot,
            "base": _pose_document(scene.T_world_base),
            "joints": problem.initial.joint_positions.tolist(),
            "home": problem.home.tolist(),
        },
        "workspace": {
            "lower": scene.workspace.lower.tolist(),
            "upper": scene.workspace.upper.tolist(),
            "overhang": scene.workspace.overhang,
        },
        "fixtures": [_fixture_document(fixture) for fixture in scene.fixtures],
        "objects": [
            _object_document(item, pose)
            for item, pose in zip(scene.objects, problem.initial.object_poses, strict=True)
        ],
        "target": scene.objects[scene.target_index].name,
        "grasps": _grasps_document(problem),
    }
    if problem.task is not Task.RETRIEVE:
        document["task"] = problem.task.value
    if problem.constraints != DEFAULT_CONSTRAINTS:
        document["constraints"] = [
            {"name": spec.name, "options": dict(spec.options)} for spec in problem.constraints
        ]
    return document


def _fixture_document(fixture: Fixture) -> dict[str, Any]:
    return {
        "name": fixture.name,
        **shape_document(fixture.shape),
        **_pose_document(fixture.pose),
        "friction": fixture.friction,
    }


def _object_document(item: SceneObject, pose: Array) -> dict[str, Any]:
    mobility = {} if item.mobility is Mobility.TARGET else {"mobility": item.mobility.value}
    return {
        "name": item.name,
        **shape_document(item.shape),
        **_pose_document(pose),
        **mobility,
        "mass": item.mass,
        "friction": item.friction,
    }


def _pose_document(pose: Array) -> dict[str, Any]:
    """With ``yaw`` if that gives back the same pose bit for bit, else with the quaternion."""
    position = pose[:3].tolist()
    yaw = 2.0 * float(np.arctan2(pose[6], pose[3]))
    for candidate in (round(yaw, 6), yaw):
        if np.array_equal(make_pose(position, candidate), pose):
            return {"position": position, "yaw": candidate}
    return {"position": position, "quat_wxyz": pose[3:].tolist()}


def _grasps_document(problem: Problem) -> str | list[dict[str, Any]]:
    if _is_automatic(problem):
        return "auto"
    return [
        {
            **_pose_document(grasp.T_object_tool),
            "approach": grasp.approach,
            "opening": grasp.opening,
        }
        for grasp in problem.grasps
    ]


def _is_automatic(problem: Problem) -> bool:
    scene = problem.scene
    try:
        automatic = automatic_grasps(scene, problem.initial.object_poses[scene.target_index])
    except InputError:  # a robot without default grasps: its grasps are written out
        return False
    return len(automatic) == len(problem.grasps) and all(
        np.array_equal(a.T_object_tool, b.T_object_tool)
        and (a.approach, a.opening) == (b.approach, b.opening)
        for a, b in zip(automatic, problem.grasps, strict=True)
    )
