"""Time parametrisation keeps its promises for any path."""

import itertools

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mamo_core.robots.limits import JointLimits
from mamo_core.robots.model import GripperModel
from mamo_core.robots.timing import BLEND, gripper_seconds, interpolated, sampled, time_path
from mamo_core.types.motion import Trajectory

BRISK = JointLimits(np.array([2.0, 1.5, 3.0]), np.array([5.0, 8.0, 10.0]), 200.0 * np.ones(3))
STIFF = JointLimits(BRISK.velocity, np.array([2.0, 15.0, 4.0]), np.array([4e3, 30.0, 50.0]))
AGILE = JointLimits(BRISK.velocity, np.full(3, 15.0), np.full(3, 7500.0))
SCALE = 0.5
ANGLES = st.floats(-3.0, 3.0, width=32)
PATHS = st.integers(2, 7).flatmap(lambda k: arrays(np.float64, (k, 3), elements=ANGLES))
LIMITS = st.sampled_from([BRISK, STIFF])
QUICK = settings(max_examples=80, deadline=None, derandomize=True)
STEP = 0.001


def long_enough(path):
    """A tenth of a second at full speed."""
    return (np.abs(np.diff(path, axis=0)) / (SCALE * BRISK.velocity)).max(axis=1).sum() > 0.1


def derivatives(trajectory):
    """Velocities, accelerations and jerks at 1 kHz, from before the start to after the end."""
    times = np.arange(-5, int(trajectory.duration / STEP) + 6) * STEP
    values = [trajectory.at(times)]
    for _ in range(3):
        values.append(np.diff(values[-1], axis=0) / STEP)
    return values[1:]


@QUICK
@given(PATHS, LIMITS)
def test_limits_at_a_thousand_hertz(path, limits):
    velocity, acceleration, jerk = derivatives(time_path(path, limits, scale=SCALE))
    assert (np.abs(velocity) <= SCALE * limits.velocity * 1.0001).all()
    assert (np.abs(acceleration) <= limits.acceleration * 1.0001).all()
    assert (np.abs(jerk) <= limits.jerk * 1.001).all()


@QUICK
@given(PATHS, st.floats(0.05, 2.0))
def test_tool_speed(path, tool_speed):
    """The first joints as a tool position: then the tool moves straight between rows."""
    assume(long_enough(path))
    trajectory = time_path(
        path, BRISK, scale=SCALE, tool_positions=0.3 * path, tool_speed=tool_speed
    )
    speeds = np.linalg.norm(0.3 * derivatives(trajectory)[0], axis=1)
    assert (speeds <= tool_speed * 1.0001).all()


def distances(points, path):
    """Of each point (k, dof) to a polyline, by the joint that is furthest away."""
    nearest = np.full(len(points), np.inf)
    for begin, end in itertools.pairwise(path):
        shares = np.linspace(0.0, 1.0, 400)[:, None, None]
        gaps = np.abs(points[None] - begin - shares * (end - begin)).max(axis=2)
        nearest = np.minimum(nearest, gaps.min(axis=0))
    return nearest


@QUICK
@given(PATHS, st.sampled_from([BRISK, AGILE]))
def test_it_keeps_close_to_the_path(path, limits):
    """Where corners are close to each other their blends may add up a little."""
    assume(long_enough(path))
    trajectory = time_path(path, limits, scale=SCALE)
    points = trajectory.at(np.linspace(0.0, trajectory.duration, 200))
    grid = np.abs(np.diff(path, axis=0)).max() / 800.0
    assert distances(points, path).max() <= 2.0 * BLEND + grid


def test_a_corner_is_blended_by_what_is_promised():
    path = np.array([[0.0, 0, 0], [1.0, 0, 0], [1.0, 1.0, 0]])
    trajectory = time_path(path, BRISK, scale=SCALE)
    points = trajectory.at(np.linspace(0.0, trajectory.duration, 2000))
    away = np.abs(points - path[1]).max(axis=1).min()
    assert 0.0002 < away <= BLEND + 1e-3
    corner = int(np.argmin(np.abs(trajectory.positions - path[1]).max(axis=1)))
    assert np.abs(trajectory.velocities[corner]).max() > 0.1  # it does not stop


@QUICK
@given(PATHS)
def test_from_rest_to_rest_at_even_times(path):
    assume(long_enough(path))
    trajectory = time_path(path, BRISK, scale=SCALE)
    assert np.array_equal(trajectory.positions[0], path[0])
    assert np.array_equal(trajectory.positions[-1], path[-1])
    assert (trajectory.velocities[[0, -1]] == 0.0).all()
    np.testing.assert_allclose(np.diff(trajectory.times), trajectory.times[1], rtol=1e-9)


@QUICK
@given(PATHS)
def test_velocities_are_those_of_the_positions(path):
    assume(long_enough(path))
    trajectory = time_path(path, BRISK, scale=SCALE)
    times = np.linspace(0.01, trajectory.duration - 0.01, 97)
    around = trajectory.at(times + 1e-5) - trajectory.at(times - 1e-5)
    np.testing.assert_allclose(trajectory.states_at(times)[1], around / 2e-5, atol=1e-4)


def test_a_straight_path_is_about_as_fast_as_can_be():
    straight = np.array([[0.0, 0, 0], [0.5, 0, 0], [1.0, 0, 0]])
    quick = time_path(straight, BRISK, scale=SCALE).duration
    assert quick == pytest.approx(1.2, abs=0.12)  # 1 rad at 1 rad/s, the ramps, their rounding


def test_a_corner_takes_time():
    straight = np.array([[0.0, 0, 0], [0.5, 0, 0], [1.0, 0, 0]])
    bent = np.array([[0.0, 0, 0], [0.5, 0, 0], [0.0, 0, 0]])
    quick = time_path(straight, BRISK, scale=SCALE).duration
    assert time_path(bent, BRISK, scale=SCALE).duration > quick + 0.05


def test_standing_still_is_one_row():
    for path in (np.zeros((1, 3)), np.zeros((4, 3))):
        trajectory = time_path(path, BRISK, scale=SCALE)
        assert (trajectory.times.tolist(), trajectory.positions.shape) == ([0.0], (1, 3))


def test_repeated_waypoints_are_dropped():
    once = np.array([[0.0, 0, 0], [0.5, 0.2, 0], [1.0, 0, 0]])
    twice = np.repeat(once, 2, axis=0)
    a, b = (time_path(path, BRISK, scale=SCALE) for path in (once, twice))
    assert np.array_equal(a.positions, b.positions)


@pytest.mark.parametrize("length", [1e-4, 0.005, 0.015])
def test_a_very_short_path(length):
    path = np.array([[0.0, 0, 0], [length, 0, 0]])
    assert 0.0 < time_path(path, BRISK, scale=SCALE).duration < 0.4


@QUICK
@given(arrays(np.float64, (4, 2), elements=ANGLES), arrays(np.float64, (4, 2), elements=ANGLES))
def test_samples_of_any_cubics_are_close_to_each_other(positions, velocities):
    trajectory = Trajectory(np.array([0.0, 0.1, 0.5, 2.0]), positions, velocities)
    rows = sampled(trajectory, 0.05)
    assert (np.abs(np.diff(rows, axis=0)) <= 0.05 + 1e-9).all()
    assert np.array_equal(rows[0], positions[0])
    np.testing.assert_allclose(rows[-1], positions[-1], atol=1e-9)


@QUICK
@given(arrays(np.float64, (5, 2), elements=ANGLES))
def test_through_overshoots_nowhere(positions):
    trajectory = Trajectory.through(np.arange(5.0), positions)
    for row in range(4):
        inside = trajectory.at(np.linspace(row, row + 1.0, 50))
        low, high = np.sort(positions[row : row + 2], axis=0)
        assert (inside >= low - 1e-9).all()
        assert (inside <= high + 1e-9).all()


def test_fingers_take_the_time_their_speed_needs():
    gripper = GripperModel(np.array([[0.0, 0.0], [0.1, 0.1]]), 0.02, 0.05, 50.0)
    assert gripper_seconds(gripper, 0.0, 0.1) == pytest.approx(2.0)
    assert gripper_seconds(gripper, 0.1, 0.05) == pytest.approx(1.0)


@QUICK
@given(PATHS, st.floats(0.01, 1.0))
def test_interpolation_keeps_waypoints_and_step(path, step):
    rows = interpolated(path, step)
    assert (np.abs(np.diff(rows, axis=0)) <= step + 1e-9).all()
    for waypoint in path:
        assert np.abs(rows - waypoint).max(axis=1).min() < 1e-9
    assert np.array_equal(rows[0], path[0])
