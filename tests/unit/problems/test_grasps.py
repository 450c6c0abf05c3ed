from __future__ import annotations

import numpy as np
import pytest

from mamo_core.errors import InputError
from mamo_core.problems.grasps import default_grasps
from mamo_core.robots.grasps import HANDS, HEIGHTS, LEAST_COVERED, Hand, hand_of
from mamo_core.robots.library import load_arm
from mamo_core.types.geometry import Box, Cylinder, Shape, matrix_from_pose, yaw_of
from mamo_core.types.scene import Mobility, SceneObject

HAND = Hand(opening=0.09, depth=0.05, clearance=0.01)


def target(shape: Shape) -> SceneObject:
    return SceneObject("t", shape, Mobility.TARGET, 0.2, 1.0)


def yaws(grasps: tuple[object, ...]) -> list[float]:
    found = [round(float(np.degrees(yaw_of(g.T_object_tool))), 3) for g in grasps]  # type: ignore[attr-defined]
    return list(dict.fromkeys(found))


def test_a_narrow_box_is_held_across_its_narrow_side() -> None:
    grasps = default_grasps(target(Box(np.array([0.12, 0.06, 0.15]))), HAND)
    assert yaws(grasps) == [0.0, 180.0]
    assert [g.opening for g in grasps] == pytest.approx([0.07] * len(grasps))


def test_a_slim_box_is_held_from_all_sides_and_a_wide_one_not_at_all() -> None:
    slim, wide = (target(Box(np.array([w, w, 0.1]))) for w in (0.06, 0.09))
    assert len(yaws(default_grasps(slim, HAND))) == 4
    assert default_grasps(wide, HAND) == ()


def test_a_cylinder_is_held_from_sixteen_sides_nearest_the_first_yaw_first() -> None:
    found = yaws(default_grasps(target(Cylinder(0.03, 0.15)), HAND, first_yaw=0.5))
    assert len(found) == 16
    assert found[0] == pytest.approx(np.degrees(0.5), abs=1e-3)
    assert found[1] - found[0] == pytest.approx(22.5, abs=1e-2)


def test_faces_nearest_the_first_yaw_come_first() -> None:
    box = target(Box(np.array([0.06, 0.06, 0.1])))
    assert yaws(default_grasps(box, HAND, first_yaw=1.7))[0] == 90.0


@pytest.mark.parametrize("half_depth", [0.03, 0.045, 0.06, 0.08])
def test_the_palm_stays_clear_of_the_near_face(half_depth: float) -> None:
    box = target(Box(np.array([2 * half_depth, 0.06, 0.2])))
    grasp = default_grasps(box, HAND)[0]
    along = float(grasp.T_object_tool[0])
    wrist = along - 0.20
    assert -half_depth - wrist >= 0.13 - 1e-12
    assert along == pytest.approx(min(0.025, HAND.depth - half_depth))
    # Before the approach the tool is the author's 7.5 cm in front of the face.
    assert along - grasp.approach <= -half_depth - 0.075 + 1e-12
    assert grasp.approach >= 0.10


def test_heights_stay_below_the_top() -> None:
    def heights(height: float) -> list[float]:
        grasps = default_grasps(target(Cylinder(0.03, height)), HAND)
        found = [round(float(g.T_object_tool[2]) + height / 2, 6) for g in grasps]
        return list(dict.fromkeys(found))

    assert heights(0.30)[: len(HEIGHTS)] == list(HEIGHTS)
    assert heights(0.13)[:2] == [h for h in HEIGHTS if h <= 0.11]
    assert heights(0.04) == [0.02]
    for height in (0.30, 0.13):
        assert max(heights(height)) <= height - 0.02 + 1e-9


def test_the_hand_is_level_first_then_dipped_and_takes_hold_by_the_fingertips_last() -> None:
    grasps = default_grasps(target(Cylinder(0.03, 0.2)), HAND)
    dips = np.array([-np.arcsin(matrix_from_pose(g.T_object_tool)[2, 0]) for g in grasps])
    # From the near side of the object to the tool, along the approach.
    past = np.array(
        [
            0.03 + float(np.linalg.norm(np.asarray(g.T_object_tool)[:2])) if dip < 1e-9 else np.nan
            for g, dip in zip(grasps, dips, strict=True)
        ]
    )
    order = np.where(dips > 1e-9, 1, np.where(past > LEAST_COVERED + 1e-9, 0, 2))
    assert order.tolist() == sorted(order.tolist())
    assert set(order.tolist()) == {0, 1, 2}
    assert (order == 0).sum() == (order == 2).sum()
    assert {round(float(dip), 3) for dip in dips} == {0.0, 0.15, 0.25, 0.35, 0.5}
    assert all(matrix_from_pose(g.T_object_tool)[2, 2] > 0.8 for g in grasps)


def test_fingers_never_open_wider_than_they_can() -> None:
    grasps = default_grasps(target(Cylinder(0.04, 0.2)), Hand(0.085, 0.05, 0.01))
    assert {g.opening for g in grasps} == {0.085}


@pytest.mark.parametrize("robot", sorted(HANDS))
def test_hands_are_those_of_the_arm_models(robot: str) -> None:
    hand, gripper = hand_of(robot), load_arm(robot).gripper
    assert gripper.max_opening - 5e-4 < hand.opening <= gripper.max_opening
    assert hand.depth <= gripper.depth


def test_an_unknown_robot_is_named_with_a_suggestion() -> None:
    with pytest.raises(InputError, match=r"'pr2_rigth_arm'.*did you mean 'pr2_right_arm'"):
        hand_of("pr2_rigth_arm")
