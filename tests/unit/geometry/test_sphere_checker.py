"""The sphere checker is conservative: what it calls free is free for the exact meshes."""

from dataclasses import replace

import numpy as np
import pytest
from mamo_geometry.options import SphereCheckerOptions
from mamo_geometry.sphere_checker import SphereChecker

from mamo_core.interfaces.collision_checker import HeldObject
from mamo_core.types.geometry import invert, make_pose, matrix_from_pose, tool_matrix


@pytest.fixture(scope="module")
def configurations(arm, reaching):
    """3,000: anywhere, in the shelf, and around there."""
    rng = np.random.default_rng(0)
    low, high = arm.around_home
    anywhere = rng.uniform(low, high, (1_000, arm.dof))
    chosen = reaching[rng.integers(len(reaching), size=2_000)]
    return np.vstack([anywhere, chosen + rng.uniform(-0.1, 0.1, chosen.shape)])


@pytest.mark.parametrize("opening", [0.0, 0.085])
def test_free_is_never_a_mesh_collision(shelf, arm, checker, exact, configurations, opening):
    poses = shelf.initial.object_poses
    opening = max(opening, arm.gripper.closed)
    free = checker.world(poses, opening=opening).free(configurations)
    assert 400 < free.sum() < 2_600
    authority = exact.world(poses, opening=opening)
    missed = [q for q in configurations[free] if authority.first_touched(q) is not None]
    assert missed == []


def at_the_edge(world, configurations, count, seed):
    """Free configurations just before something is touched: ``count`` bisections at most."""
    free = world.free(configurations)
    rng = np.random.default_rng(seed)
    inside = configurations[free][rng.integers(free.sum(), size=count)]
    outside = configurations[~free][rng.integers((~free).sum(), size=count)]
    # Near pairs: the arm moves little, the touching part is the hand's.
    outside = inside + 0.3 * (outside - inside)
    keep = ~world.free(outside)
    inside, outside = inside[keep], outside[keep]
    for _ in range(14):
        middle = (inside + outside) / 2.0
        free = world.free(middle)[:, None]
        inside, outside = np.where(free, middle, inside), np.where(free, outside, middle)
    return inside


@pytest.mark.parametrize("opening", [0.0, 0.085])
def test_the_last_free_configuration_is_no_collision(shelf, arm, checker, exact, reaching, opening):
    poses = shelf.initial.object_poses
    opening = max(opening, arm.gripper.closed)
    last = at_the_edge(checker.world(poses, opening=opening), reaching, 3_000, seed=1)
    assert len(last) > 600
    authority = exact.world(poses, opening=opening)
    assert [q for q in last if authority.first_touched(q) is not None] == []


def test_it_is_not_too_careful(shelf, checker, exact, reaching):
    """At least seven of ten configurations in the shelf that are free are found so."""
    poses = shelf.initial.object_poses
    movables = [shelf.scene.objects[i].name for i in shelf.scene.movable_indices]
    authority = exact.world(poses, opening=0.0, ignore=movables)
    really = authority.free(reaching)
    found = checker.world(poses, opening=0.0, ignore=movables).free(reaching)
    assert really.sum() > 50
    assert found.sum() > 0.7 * really.sum()


def held_target(shelf, kinematics, q):
    """The target moved into the hand, upright, as a grasp holds it."""
    target = shelf.scene.objects[shelf.scene.target_index]
    T_tool_object = np.eye(4)
    T_tool_object[2, 3] = 0.02
    return HeldObject(target.name, target.shape, T_tool_object)


def test_free_with_a_held_object_is_never_a_collision(shelf, arm, kinematics, exact, reaching):
    """Arm by exact meshes; the held object's own solid against everything else."""
    options = SphereCheckerOptions(max_held_tilt_deg=180.0)
    checker = SphereChecker(shelf.scene, arm, options)
    poses = shelf.initial.object_poses
    rng = np.random.default_rng(3)
    chosen = reaching[rng.integers(len(reaching), size=1_500)]
    configurations = chosen + rng.uniform(-0.05, 0.05, chosen.shape)
    held = held_target(shelf, kinematics, configurations[0])
    world = checker.world(poses, opening=0.085, ignore=[held.name], held=held)
    free = world.free(configurations)
    assert 20 < free.sum() < 1_480
    authority = exact.world(poses, opening=0.085, ignore=[held.name], held=held)
    assert [q for q in configurations[free] if authority.first_touched(q) is not None] == []


def test_the_held_object_counts(shelf, arm, checker, kinematics, reaching):
    poses = shelf.initial.object_poses
    held = held_target(shelf, kinematics, reaching[0])
    without = checker.world(poses, opening=0.085, ignore=[held.name]).free(reaching)
    with_it = checker.world(poses, opening=0.085, ignore=[held.name], held=held).free(reaching)
    assert with_it.sum() < without.sum()
    assert not (with_it & ~without).any()


def test_a_held_object_stays_upright(shelf, arm, checker, kinematics, reaching):
    """Configurations that tilt the tool more than the limit are not free while it holds."""
    poses = shelf.initial.object_poses + np.array([9.0, 0, 0, 0, 0, 0, 0])
    held = held_target(shelf, kinematics, reaching[0])
    boards = [fixture.name for fixture in shelf.scene.fixtures]
    world = checker.world(poses, opening=0.085, ignore=[held.name, *boards], held=held)
    up = np.array([kinematics.forward(q)[2, 2] for q in reaching])
    tilted = up < np.cos(np.radians(18.0))
    assert 20 < tilted.sum() < len(reaching) - 20
    assert not world.free(reaching[tilted]).any()
    assert world.free(reaching[~tilted]).mean() > 0.5


def test_ignored_objects_and_fixtures_do_not_count(shelf, checker, reaching):
    poses = shelf.initial.object_poses
    names = [o.name for o in shelf.scene.objects]
    boards = [f.name for f in shelf.scene.fixtures]
    nothing = checker.world(poses, opening=0.0, ignore=[*names, *boards]).free(reaching)
    boards_only = checker.world(poses, opening=0.0, ignore=names).free(reaching)
    everything = checker.world(poses, opening=0.0).free(reaching)
    assert everything.sum() < boards_only.sum() < nothing.sum()
    assert not (everything & ~boards_only).any()


def test_margin(shelf, checker, reaching):
    poses = shelf.initial.object_poses
    near = checker.world(poses, opening=0.0).free(reaching)
    far = checker.world(poses, opening=0.0, margin=0.03).free(reaching)
    assert far.sum() < near.sum()
    assert not (far & ~near).any()


def test_the_own_body_is_in_the_way(arm, checker, exact, shelf):
    """The arm folded into the torso, far from all objects."""
    poses = shelf.initial.object_poses
    q = arm.home.copy()
    q[0], q[1] = 0.7, 1.2
    assert not checker.world(poses, opening=0.0).free(q)[0]
    world = exact.world(poses, opening=0.0)
    assert not world.free(q)[0]
    assert world.first_touched(q) is None


def test_edges(shelf, checker, exact, reaching):
    """A free edge is free all along, with exact meshes; both ends count."""
    poses = shelf.initial.object_poses
    world = checker.world(poses, opening=0.0)
    starts, ends = reaching[:-1:2], reaching[1::2]
    free = world.edges_free(starts, ends)
    assert free.sum() > 10
    assert not (free & ~(world.free(starts) & world.free(ends))).any()
    authority = exact.world(poses, opening=0.0)
    for a, b in zip(starts[free][:15], ends[free][:15], strict=True):
        assert authority.edges_free(a, b)[0]


def test_an_edge_with_free_ends_may_be_blocked(shelf, checker, kinematics):
    """Left and right of a thin post that nothing else would notice."""
    index = shelf.scene.target_index
    names = [o.name for i, o in enumerate(shelf.scene.objects) if i != index]
    boards = [f.name for f in shelf.scene.fixtures]
    poses = np.array(shelf.initial.object_poses)
    T = tool_matrix([0.7, -0.35, 0.9], 0.0)
    q = kinematics.inverse(T, np.random.default_rng(0), count=1)[0]
    T_end = T.copy()
    T_end[1, 3] = -0.75
    path = kinematics.follow_line(q, T_end).path
    assert len(path) > 30
    poses[index] = make_pose([0.7, -0.55, 0.9])
    world = checker.world(poses, opening=0.0, ignore=[*names, *boards])
    ends = path[[0, -1]]
    assert world.free(ends).all()
    assert not world.free(path).all()
    steps = world.edges_free(path[:-1], path[1:])
    assert not steps.all()
    assert steps[0]
    assert steps[-1]


def test_hands_free_is_the_check_of_the_hand_alone(shelf, checker, kinematics, reaching):
    """Where the hand is not free the arm is not; both answers occur."""
    world = checker.world(shelf.initial.object_poses, opening=0.0)
    hands = world.hands_free(np.array([kinematics.forward(q) for q in reaching]))
    arms = world.free(reaching)
    assert not (arms & ~hands).any()
    assert 0 < hands.sum() < len(hands)
    assert arms.sum() > 0.5 * hands.sum()


def test_upright_is_as_the_object_was_taken(shelf, arm, checker, kinematics, reaching):
    """Taken by a dipped hand, the object is upright while the hand is dipped as it was then."""
    poses = shelf.initial.object_poses + np.array([9.0, 0, 0, 0, 0, 0, 0])
    boards = [fixture.name for fixture in shelf.scene.fixtures]
    held = held_target(shelf, kinematics, reaching[0])
    up = np.array([-np.sin(0.5), 0.0, np.cos(0.5)])
    dipped = replace(held, up=up)
    ignore = [held.name, *boards]
    free = checker.world(poses, opening=0.085, ignore=ignore, held=dipped).free(reaching)
    limit = np.cos(np.radians(18.0))
    vertical = np.array([kinematics.forward(q)[2, :3] @ up for q in reaching])
    assert free.any()
    assert (vertical[free] >= limit - 1e-9).all()
    loose = SphereChecker(shelf.scene, arm, SphereCheckerOptions(max_held_tilt_deg=180.0))
    anyhow = loose.world(poses, opening=0.085, ignore=ignore, held=dipped).free(reaching)
    assert np.array_equal(free, anyhow & (vertical >= limit))


def test_exact_checker_names_what_is_touched(shelf, arm, exact, kinematics):
    item = shelf.scene.objects[shelf.scene.target_index]
    q = arm.home
    T = kinematics.forward(q)
    poses = np.array(shelf.initial.object_poses)
    poses[shelf.scene.target_index] = make_pose(T[:3, 3])
    assert exact.world(poses, opening=0.0).first_touched(q) == item.name
    assert exact.world(poses, opening=0.0, ignore=[item.name]).first_touched(q) is None
    with pytest.raises(ValueError, match="margin"):
        exact.world(poses, opening=0.0, margin=0.01)


def test_exact_checker_and_a_held_object(shelf, arm, exact, kinematics):
    """Held inside another object: touching; the arm itself is clear."""
    target = shelf.scene.objects[shelf.scene.target_index]
    other = shelf.scene.index(shelf.scene.objects[shelf.scene.movable_indices[0]].name)
    T_tool = kinematics.forward(arm.home)
    T_object = T_tool.copy()
    T_object[:3, 3] += [0.0, 0.0, 0.5]
    poses = np.array(shelf.initial.object_poses)
    poses[other] = make_pose(T_object[:3, 3])
    held = HeldObject(target.name, target.shape, invert(T_tool) @ T_object)
    ignore = [target.name]
    assert exact.world(poses, opening=0.0, ignore=ignore).first_touched(arm.home) is None
    assert (
        exact.world(poses, opening=0.0, ignore=ignore, held=held).first_touched(arm.home)
        is not None
    )
    assert matrix_from_pose(poses[other])[2, 3] == pytest.approx(T_object[2, 3])
