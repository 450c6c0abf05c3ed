"""Pushes beside the centre: what they do, how far a box is from leaving, which are proposed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mamo_planners.actions.push import Push
from mamo_planners.actions.push_line import beside_centre
from mamo_planners.actions.sliding import slid
from mamo_planners.actions.turn import Turn
from mamo_planners.actions.way_out import NEVER, STEP, WaysOut
from mamo_planners.footprints import Outlines
from mamo_planners.options import PushOptions, TurnOptions

from mamo_core.interfaces.action_generator import ActionRequest
from mamo_core.types.geometry import Box, Cylinder, footprint_corners, make_pose, yaw_of
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility, SceneState
from mamo_core.types.solution import Statistics

WIDE = Box(np.array([0.1, 0.16, 0.2]))
QUICK = settings(max_examples=60, deadline=None, derandomize=True)
LENGTHS = np.linspace(0.001, 0.1, 100)


def unit(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def pushed(contact, direction, start=(0.0, 0.0, 0.0), shape=WIDE):
    """Poses after pushes of ``LENGTHS``."""
    one = np.asarray(contact, dtype=float)[None], np.asarray(direction, dtype=float)[None]
    return slid(shape, np.array(start), *one, LENGTHS)[0]


def strip(left, right, origin=(0.4, -1.0), size=(80, 110)):
    """A region that sweeps all between two values of y."""
    lowest = np.full(size, np.inf)
    y = origin[1] + (np.arange(size[1]) + 0.5) * 0.01
    lowest[:, (y > right) & (y < left)] = 0.8
    return SweptRegion(np.array(origin), 0.01, lowest, 0.77)


@pytest.fixture(scope="module")
def problem(shelf_with):
    """A wide box 3 cm beside the right wall, the target and a post elsewhere."""
    return shelf_with(
        {
            "blocker": (WIDE, Mobility.MOVABLE, (0.6, -0.79)),
            "beside": (Cylinder(0.03, 0.15), Mobility.MOVABLE, (0.6, -0.3)),
            "target": (Cylinder(0.03, 0.16), Mobility.TARGET, (0.8, -0.6)),
        }
    )


REGION = strip(-0.55, -0.76)
"""Leaves 14 cm between itself and the right wall: too little for the box as it stands."""


@pytest.fixture(scope="module")
def turn(problem, parts_of):
    parts = parts_of(problem)
    push = Push(
        problem,
        parts.arm,
        parts.kinematics,
        parts.collision,
        parts.arm_planner,
        PushOptions(samples=2),
        kind="turn",
    )
    return Turn(problem, push, TurnOptions())


def test_through_the_centre_nothing_turns():
    poses = pushed([-0.05, 0.0], [1.0, 0.0], start=(0.0, 0.0, 0.0))
    assert poses[:, 0] == pytest.approx(LENGTHS)
    assert np.abs(poses[:, 1:]).max() == pytest.approx(0.0)


@QUICK
@given(
    st.floats(-3.0, 3.0),
    st.floats(-3.0, 3.0),
    st.floats(-0.07, 0.07),
    st.sampled_from([WIDE, Cylinder(0.05, 0.1)]),
)
def test_the_pushed_point_goes_with_the_hand(yaw, angle, beside, shape):
    direction, start = unit(angle), np.array([0.3, -0.2, yaw])
    contact = start[:2] - 0.05 * direction + beside * unit(angle + np.pi / 2)
    end = pushed(contact, direction, start, shape)[-1]
    lever, turned = contact - start[:2], end[2] - yaw
    rotation = np.array([unit(turned), unit(turned + np.pi / 2)]).T
    goes_to = end[:2] + rotation @ lever
    assert np.linalg.norm(goes_to - (contact + LENGTHS[-1] * direction)) < 2e-3
    # A push to the right of the centre turns to the left, and the other way round.
    assert abs(beside) < 1e-3 or np.sign(turned) == -np.sign(beside)


@QUICK
@given(st.floats(-3.0, 3.0))
def test_lines_begin_at_the_edge_and_go_inside(yaw):
    pose = make_pose([0.6, -0.4, 0.87], yaw)
    lines = beside_centre(WIDE, pose)
    axes = np.array([unit(yaw), unit(yaw + np.pi / 2)])
    assert len({(*line.contact.round(9), *line.direction.round(9)) for line in lines}) == len(lines)
    for line in lines:
        inset = WIDE.size[:2] / 2.0 - np.abs(axes @ (line.contact - pose[:2]))
        assert inset.min() == pytest.approx(0.0, abs=1e-9)
        inside = np.abs(axes @ (line.contact + 1e-4 * line.direction - pose[:2]))
        assert (inside < WIDE.size[:2] / 2.0).all()
        assert line.by(0.1).delta == pytest.approx(0.1 * line.direction)


def test_where_no_step_is_left_the_box_is_out(problem):
    """Against the region, the obstacles and the bounds themselves, at random cells."""
    way = WaysOut(problem).of(problem.scene.index("blocker"), REGION)
    scene, poses = problem.scene, problem.initial.object_poses
    fixed = [i for i, o in enumerate(scene.objects) if o.mobility is not Mobility.MOVABLE]
    obstacles = Outlines([footprint_corners(scene.objects[i].shape, poses[i]) for i in fixed])
    height = poses[scene.index("blocker"), 2]
    rng, seen = np.random.default_rng(0), set()
    for _ in range(1500):
        cell = [int(rng.integers(n)) for n in way.steps.shape]
        yaw = cell[2] * np.pi / way.steps.shape[2]
        pose = make_pose([*(way.origin + STEP * np.array(cell[:2])), height], yaw)
        corners = footprint_corners(WIDE, pose)
        low, high = scene.workspace.lower[:2], scene.workspace.upper[:2]
        within = (corners > low - 1e-9).all() and (corners < high + 1e-9).all()
        out = (
            within
            and not REGION.overlaps(WIDE, pose)
            and not obstacles.overlapped(corners[None])[0]
        )
        planar = np.array([*pose[:2], yaw])
        assert (way.left(planar) == 0) == out
        assert way.left(planar + np.array([0.0, 0.0, np.pi])) == way.left(planar)
        seen.add(out)
    assert seen == {False, True}


def test_the_box_has_to_turn(problem, turn):
    """There is no way out without turning, and one that is about a quarter of a turn long."""
    number = problem.scene.index("blocker")
    way = WaysOut(problem).of(number, REGION)
    x, y, _ = problem.initial.object_poses[number, :3]
    layers = way.steps.shape[2]
    places = np.arange(-0.1, 0.0301, 0.01)
    assert all(way.left(np.array([x, y - d, 0.0])) > 0 for d in places)
    left = int(way.left(np.array([x, y, 0.0])))
    assert layers / 4 < left < layers


def test_boxed_in_there_is_no_way_out(shelf_with):
    side, end = Box(np.array([0.02, 0.4, 0.2])), Box(np.array([0.15, 0.02, 0.2]))
    boxed = shelf_with(
        {
            "post": (side, Mobility.IMMOVABLE, (0.54, -0.7)),
            "target": (side, Mobility.TARGET, (0.67, -0.7)),
            "beside": (end, Mobility.IMMOVABLE, (0.605, -0.48)),
            "blocker": (Box(np.array([0.08, 0.2, 0.2])), Mobility.MOVABLE, (0.605, -0.7)),
        }
    )
    number, swept = boxed.scene.index("blocker"), strip(-0.4, -0.9)
    start = np.array([*boxed.initial.object_poses[number, :2], 0.0])
    assert WaysOut(boxed).of(number, swept).left(start) == NEVER
    assert WaysOut(boxed, gone=["beside"]).of(number, swept).left(start) < NEVER


def test_proposals_push_beside_the_centre(problem, turn):
    statistics = Statistics()
    request = ActionRequest("blocker", None, REGION)
    found = list(turn.propose(problem.initial, request, np.random.default_rng(0), statistics))
    assert 0 < len(found) <= TurnOptions().samples, statistics.causes
    assert {action.kind for action in found} == {"turn"}
    assert {key.split("/")[1] for key in statistics.causes} <= {"turn"}


def test_what_is_round_or_out_of_the_way_is_left_alone(problem, turn):
    for name, region in (("beside", REGION), ("blocker", strip(-0.3, -0.5))):
        statistics = Statistics()
        request = ActionRequest(name, None, region)
        rng = np.random.default_rng(0)
        assert list(turn.propose(problem.initial, request, rng, statistics)) == []
        causes = +statistics.causes
        assert causes == ({} if name == "beside" else {"blocker/turn/no_turn_helps": 1})
    assert turn.progress(problem.initial, ActionRequest("beside", None, REGION)) is None


def test_progress_is_to_come_nearer_to_a_place_outside(problem, turn):
    number = problem.scene.index("blocker")
    accepts = turn.progress(problem.initial, ActionRequest("blocker", None, REGION))

    def turned(degrees, right=0.0):
        poses = np.array(problem.initial.object_poses)
        x, y, z = poses[number, :3]
        poses[number] = make_pose([x, y - right, z], np.radians(degrees))
        assert yaw_of(poses[number]) == pytest.approx(np.radians(degrees))
        return SceneState(problem.home, poses)

    assert all(accepts(state) for state in (turned(60.0), turned(-60.0), turned(90.0, 0.05)))
    assert not accepts(problem.initial)
    assert not accepts(turned(4.0))
