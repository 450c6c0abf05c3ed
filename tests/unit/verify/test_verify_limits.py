"""Every kind of limit that a controller would refuse to exceed."""

from dataclasses import replace

import numpy as np
import pytest

from mamo_core.robots.library import load_arm
from mamo_core.robots.timing import gripper_seconds, time_path
from mamo_core.types.motion import MotionSegment, SegmentKind, Trajectory
from mamo_core.verify_limits import check_limits

ARM = load_arm("panda")
HOME = np.array(ARM.home)
CLOSED, WIDE = ARM.gripper.closed, ARM.gripper.max_opening


def segment(trajectory, opening=CLOSED):
    return MotionSegment(SegmentKind.TRANSIT, trajectory, opening)


def swing():
    """Along the first joint and back by another one."""
    path = np.stack([HOME, HOME + np.eye(7)[0], HOME + np.eye(7)[0] - 0.5 * np.eye(7)[3]])
    return time_path(path, ARM.limits, scale=1.0)


def failures(trajectory, opening=CLOSED, before=CLOSED):
    return check_limits(segment(trajectory, opening), before, ARM)


def hurried(share):
    """The swing in a share of its time."""
    times, velocities = swing().times * share, swing().velocities / share
    return replace(swing(), times=times, velocities=velocities)


def test_what_uses_its_limits_is_fine():
    assert failures(swing()) == []


def test_faster_than_the_limits_is_not():
    """All of the velocity is used: eight tenths of the time are a quarter too fast."""
    assert any(
        f.startswith("velocity limit exceeded: panda_joint1 at 125 %")
        for f in failures(hurried(0.8))
    )


def test_what_leaves_room_may_be_hurried():
    calm = time_path(np.stack([HOME, HOME + np.eye(7)[0]]), ARM.limits, scale=0.3)
    eased = replace(calm, times=calm.times * 0.8, velocities=calm.velocities / 0.8)
    assert failures(eased) == []


def test_position_between_rows():
    """The rows are within the limits, the cubic between them is not."""
    high = np.array(HOME)
    high[5] = ARM.upper[5] - 0.01
    speed = np.zeros((2, 7))
    speed[:, 5] = 1.0, -1.0
    found = failures(Trajectory(np.array([0.0, 0.2]), np.stack([high, high]), speed))
    assert any("panda_joint6 exceeds its limit by 4.00e-02 rad" in f for f in found)


def test_acceleration():
    """From rest to a modest speed in no time at all."""
    way = HOME + 0.1 * np.eye(7)[1] * np.linspace(0.0, 1.0, 3)[:, None]
    found = failures(Trajectory.through(np.array([0.0, 0.06, 0.12]), way))
    assert any(f.startswith("acceleration limit exceeded: panda_joint2") for f in found)
    assert not any(f.startswith("velocity") for f in found)


def test_jerk_alone():
    """Four fifths of the acceleration up, and from one step to the next down."""
    along = np.eye(7)[1]
    way = HOME + np.array([0.0, 0.03, 0.06])[:, None] * along
    speeds = np.array([0.0, 0.6, 0.0])[:, None] * along
    found = failures(Trajectory(np.array([0.0, 0.1, 0.2]), way, speeds))
    assert [f.split(":")[0] for f in found] == ["jerk limit exceeded"]


@pytest.mark.parametrize("row", [0, -1])
def test_rest(row):
    velocities = np.array(swing().velocities)
    velocities[row, 2] = 1e-3
    found = failures(replace(swing(), velocities=velocities))
    name = "start" if row == 0 else "end"
    assert f"it does not {name} at rest, but with 0.001 rad/s" in found


def test_gripper_speed():
    seconds = gripper_seconds(ARM.gripper, CLOSED, WIDE)
    assert failures(Trajectory.still(HOME, seconds), opening=WIDE) == []
    found = failures(Trajectory.still(HOME, seconds / 2.0), opening=WIDE)
    assert found == ["gripper speed limit exceeded: 200 %"]
    assert failures(Trajectory.still(HOME, 0.0), opening=WIDE) == [
        "gripper speed limit exceeded: inf %"
    ]


def test_an_opening_that_there_is_not():
    found = failures(Trajectory.still(HOME, 5.0), opening=WIDE + 0.01)
    assert found == [f"opening {WIDE + 0.01} m is not possible"]
