"""The robot against itself: pairs, fields, tables, exact checks, and what verify says of plans."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from mamo_geometry.options import SphereCheckerOptions
from mamo_geometry.sphere_checker import SphereChecker

from mamo_core.interfaces.collision_checker import HeldObject
from mamo_core.problems import generate_shelf
from mamo_core.robots import load_arm
from mamo_core.robots.distance_field import CELL, HALF_DIAGONAL, STEP, measure_field
from mamo_core.robots.self_collision import SelfCollisions, check_self_collisions
from mamo_core.robots.specs import SPECS
from mamo_core.types.geometry import Box, make_pose
from mamo_core.types.motion import MotionSegment, SegmentKind, Trajectory
from mamo_core.types.scene import Mobility, Scene, SceneObject, Workspace

ARMS = sorted(SPECS)


def alone(arm, opening, held=None):
    """The sphere checker's world of the robot alone."""
    target = SceneObject("target", Box(np.full(3, 0.05)), Mobility.TARGET, 0.1, 1.0)
    space = Workspace(np.array([9.0, -0.5, 0.0]), np.array([10.0, 0.5, 1.0]))
    scene = Scene(arm.name, make_pose([0.3, -0.2, 0.1], 0.7), (), (target,), space)
    checker = SphereChecker(scene, arm, SphereCheckerOptions(max_held_tilt_deg=180.0))
    ignore = [] if held is None else [held.name]
    poses = np.array([make_pose([9.5, 0.0, 0.0])])
    return checker.world(poses, opening=opening, held=held, ignore=ignore)


def anywhere(arm, count, seed=0):
    low, high = arm.around_home
    return np.random.default_rng(seed).uniform(low, high, (count, arm.dof))


@pytest.mark.parametrize("name", ARMS)
def test_free_is_never_a_collision_with_itself_and_often_found(name):
    arm = load_arm(name)
    for opening in (arm.gripper.closed, arm.gripper.max_opening):
        rows = anywhere(arm, 800)
        quick, truth = alone(arm, opening).free(rows), SelfCollisions(arm).free(rows, opening)
        assert 50 < (~truth).sum() < 400
        assert not (quick & ~truth).any()
        assert quick.sum() > 0.85 * truth.sum()


@pytest.mark.parametrize("name", ARMS)
def test_what_is_held_counts(name):
    arm, opening = load_arm(name), load_arm(name).gripper.max_opening
    held = HeldObject("target", Box(np.array([0.06, 0.06, 0.5])), np.eye(4))
    rows = anywhere(arm, 800, seed=1)
    truth = SelfCollisions(arm, held).free(rows, opening)
    quick = alone(arm, opening, held).free(rows)
    assert not (quick & ~truth).any()
    bare = SelfCollisions(arm).free(rows, opening)
    assert (bare & ~truth).sum() > 20
    assert not (truth & ~bare).any()


@pytest.mark.parametrize("name", ARMS)
def test_home_is_free(name):
    arm = load_arm(name)
    for opening in (arm.gripper.closed, arm.gripper.max_opening):
        assert alone(arm, opening).free(arm.home)[0]
        assert SelfCollisions(arm).first(arm.home, opening) is None


def test_the_whole_robot_is_there():
    names = {part.name for part in load_arm("pr2_right_arm").body}
    assert {"base_link", "torso_lift_link", "head_tilt_link", "l_forearm_link"} <= names
    assert [part.name for part in load_arm("panda").body] == ["panda_link0"]


@pytest.mark.parametrize("name", ARMS)
def test_pairs(name):
    """None of neighbours or within the hand; the hand against what carries the arm is one."""
    arm = load_arm(name)
    links, pairs = len(arm.links), set(arm.self_pairs)
    hand = {arm.tool_link, *(k for k, link in enumerate(arm.links) if link.coordinate < 0)}
    assert set(arm.hull_pairs) < pairs or set(arm.hull_pairs) == pairs
    for one, other in pairs:
        assert one < links
        assert arm.links[one].parent != other
        assert not {one, other} <= hand
    mount = {"panda": "panda_link0", "pr2_right_arm": "torso_lift_link"}[name]
    assert (arm.tool_link, arm.part_names.index(mount)) in pairs


def test_the_torso_is_named():
    arm = load_arm("pr2_right_arm")
    q = arm.home.copy()
    q[:4] = 0.5, 0.6, 0.0, -2.2
    q[5] = -0.5
    rows = anywhere(arm, 2_000, seed=3)
    own = SelfCollisions(arm)
    bad = rows[~own.free(rows, 0.0)]
    found = {own.first(row, 0.0)[1] for row in bad}
    assert {"torso_lift_link", "base_link"} <= found


@pytest.mark.parametrize("solid", [False, True])
def test_a_field_is_never_too_large(solid):
    mesh = trimesh.creation.box((0.1, 0.2, 0.3))
    field = measure_field(-1, (), [] if solid else [mesh], [mesh] if solid else [])
    rng = np.random.default_rng(0)
    points = rng.uniform(field.lower - 0.1, field.upper + 0.1, (5_000, 3))
    cells = np.floor((points - field.origin) / CELL).astype(int)
    bounds = STEP * field.values[tuple(cells.T)] - HALF_DIAGONAL
    beyond = np.abs(points) - np.array([0.05, 0.1, 0.15])
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    depth = np.maximum(-beyond.max(axis=1), 0.0)
    distance = outside + (0.0 if solid else depth)
    assert (bounds <= distance + 1e-9).all()
    assert (bounds > distance - 0.03)[distance < 0.08].all()


def test_a_panda_may_fold_as_far_as_its_meshes_allow():
    arm = load_arm("panda")
    folded = np.array([[-2.6026, 1.2518, 2.3161, -3.0472, -2.8385, 2.6141, -0.2622]])
    assert SelfCollisions(arm).free(folded, arm.gripper.closed).all()
    assert alone(arm, arm.gripper.closed).free(folded).all()


def through_the_torso(arm):
    """A sweep of the arm into the robot's own body."""
    end = arm.home.copy()
    end[0], end[1] = 0.7, 1.2
    path = np.linspace(arm.home, end, 20)
    return MotionSegment(
        SegmentKind.SWEEP,
        Trajectory(np.linspace(0.0, 4.0, 20), path, np.zeros_like(path)),
        arm.gripper.closed,
    )


def test_a_sweep_through_the_torso_is_found_and_named():
    arm = load_arm("pr2_right_arm")
    problem = generate_shelf(movables=1, seed=1)
    segment, closed = through_the_torso(arm), arm.gripper.closed
    found = check_self_collisions(problem.scene, [segment], [problem.initial], arm, closed)
    assert len(found) == 1
    assert found[0].startswith("sweep: ")
    assert " collides with " in found[0]
    still = replace(segment, trajectory=Trajectory.still(arm.home, 0.0))
    assert check_self_collisions(problem.scene, [still], [problem.initial], arm, closed) == []
