"""What two fingers can carry, against what can be worked out by hand."""

import numpy as np
import pytest

from mamo_core.robots import load_arm
from mamo_core.robots.fingers import GIVE, finger_drives, finger_effort, finger_stiffness
from mamo_core.robots.grip import (
    ACCELERATION,
    GRAVITY,
    SAFETY,
    TILT,
    Pad,
    Patch,
    grip_fault,
    load_share,
    pad_of,
    patch_of,
)
from mamo_core.types.geometry import Box, Cylinder
from mamo_core.types.scene import Mobility, SceneObject

PAD = Pad(-0.04, -0.01, 0.01)


def at(x, y=0.0, z=0.0):
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def item(shape, mass=0.5, friction=1.0):
    return SceneObject("thing", shape, Mobility.MOVABLE, mass, friction)


@pytest.mark.parametrize(
    ("robot", "width", "expected"),
    [
        ("pr2_right_arm", 0.06, Pad(-0.042, -0.0098, 0.0099)),
        ("panda", 0.05, Pad(-0.0185, 0.0, 0.00875)),
    ],
)
def test_pads_are_measured_on_the_hand(robot, width, expected):
    pad = pad_of(load_arm(robot), width)
    found = (pad.back, pad.front, pad.half_height)
    assert found == pytest.approx((expected.back, expected.front, expected.half_height), abs=5e-4)


def test_a_box_is_pressed_wherever_the_pad_covers_it():
    box = Box(np.array([0.2, 0.06, 0.2]))
    patch = patch_of(box, at(0.0), PAD)
    assert patch.centre == pytest.approx([-0.025, 0.0, 0.0], abs=1e-9)
    edge = patch_of(box, at(-0.025 - 0.1), PAD)  # the box ends in the middle of the pad
    assert edge.centre[0] == pytest.approx(-0.0325, abs=1e-3)
    assert edge.radius < patch.radius
    assert patch_of(box, at(0.1), PAD) is None
    assert patch_of(box, at(-0.025, z=0.2), PAD) is None


def test_a_cylinder_is_pressed_along_a_stripe():
    patch = patch_of(Cylinder(0.03, 0.2), at(-0.025), PAD)
    assert patch.centre == pytest.approx([-0.025, 0.0, 0.0], abs=1e-9)
    stripe = 0.01 / 2.0  # of a line as high as the pad
    assert stripe <= patch.radius < 0.008


def test_shares_of_force_and_torque():
    patch = Patch(np.array([-0.025, 0.0, 0.0]), 0.01)
    weight = 0.5 * (GRAVITY + ACCELERATION)
    held, turned = load_share(0.5, 0.8, 50.0, at(0.005, z=0.02), patch)
    assert held == pytest.approx(weight / (2 * 0.8 * 50.0))
    lever = 0.03 * np.cos(TILT) + 0.02 * np.sin(TILT)
    assert turned == pytest.approx(weight * lever / (2 * 0.8 * 50.0 * 0.01))


def test_the_limits_of_weight_and_lever():
    arm = load_arm("pr2_right_arm")
    box = Box(np.array([0.2, 0.06, 0.2]))
    middle, width = at(-0.026), 0.06
    heaviest = 2.0 * 1.0 * arm.gripper.force / (SAFETY * (GRAVITY + ACCELERATION))
    assert grip_fault(item(box, 0.9 * heaviest), middle, width, arm) is None
    assert grip_fault(item(box, 1.1 * heaviest), middle, width, arm) == "grip_too_weak"
    assert grip_fault(item(box, 1.0, 0.1), middle, width, arm) == "grip_too_weak"
    far = at(-0.026 + 0.09)
    assert grip_fault(item(box, 0.1), far, width, arm) is None
    assert grip_fault(item(box, 1.0), far, width, arm) == "grip_would_turn"
    assert grip_fault(item(box, 0.1), at(0.3), width, arm) == "grip_missed"


@pytest.mark.parametrize("robot", ["pr2_right_arm", "panda"])
def test_the_work_of_the_joints_is_that_of_the_fingers(robot):
    """Never more than the gripper's force, and hardly less in the middle of the way."""
    arm = load_arm(robot)
    gripper = arm.gripper
    fingers = sum(link.coordinate < 0 for link in arm.links)
    step = 1e-3
    for opening in np.linspace(0.02, 0.07, 6):
        dq = gripper.drive(opening + step) - gripper.drive(opening - step)
        force = fingers * finger_effort(arm) * dq / (2.0 * step)
        assert 0.85 * gripper.force < force <= 1.01 * gripper.force
    middle = gripper.drive(0.05) - gripper.drive(0.05 - 2.0 * GIVE)
    assert finger_stiffness(arm) * middle == pytest.approx(finger_effort(arm), rel=0.15)


def test_tips_follow_the_fingers_that_carry_them():
    arm = load_arm("pr2_right_arm")
    drives = finger_drives(arm, 400.0)
    assert [drive.follows for drive in drives] == [None, 0, None, 2]
    assert drives[1].effort == 400.0
    assert drives[0].effort == pytest.approx(2.0 * finger_effort(arm))
    assert [drive.follows for drive in finger_drives(load_arm("panda"), 400.0)] == [None, None]
