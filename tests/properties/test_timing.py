"""Time parametrisation keeps its promises for any path."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mamo_core.robots.timing import _cut, _limited, interpolated, time_path

LIMITS = np.array([2.0, 1.5, 3.0])
SCALE = 0.5
ANGLES = st.floats(-3.0, 3.0, width=32)
PATHS = st.integers(2, 7).flatmap(lambda k: arrays(np.float64, (k, 3), elements=ANGLES))
QUICK = settings(max_examples=80, deadline=None, derandomize=True)


def long_enough(path):
    """A tenth of a second at full speed."""
    return (np.abs(np.diff(path, axis=0)) / (SCALE * LIMITS)).max(axis=1).sum() > 0.1


def speeds(trajectory):
    return np.diff(trajectory.positions, axis=0) / np.diff(trajectory.times)[:, None]


@QUICK
@given(PATHS)
def test_velocity_limits(path):
    assume(long_enough(path))
    assert (np.abs(speeds(time_path(path, LIMITS, scale=SCALE))) <= SCALE * LIMITS * 1.0001).all()


@QUICK
@given(PATHS, st.floats(0.05, 2.0))
def test_tool_speed(path, tool_speed):
    """The first joints as a tool position: then the tool moves straight between rows."""
    assume(long_enough(path))
    trajectory = time_path(
        path, LIMITS, scale=SCALE, tool_positions=0.3 * path, tool_speed=tool_speed
    )
    assert (np.linalg.norm(0.3 * speeds(trajectory), axis=1) <= tool_speed * 1.0001).all()


@QUICK
@given(PATHS)
def test_passes_through_every_waypoint_in_order(path):
    assume(long_enough(path))
    positions = time_path(path, LIMITS, scale=SCALE).positions
    assert np.array_equal(positions[0], path[0])
    row = 0
    for waypoint in path:
        ahead = np.abs(positions[row:] - waypoint).max(axis=1)
        assert ahead.min() < 1e-6
        row += int(np.argmin(ahead > 1e-6))
    np.testing.assert_allclose(positions[-1], path[-1], atol=1e-6)


@QUICK
@given(PATHS)
def test_starts_and_ends_slowly(path):
    """The first and the last piece are at a quarter of the speed at most."""
    assume(long_enough(path))
    found = np.abs(speeds(time_path(path, LIMITS, scale=SCALE))[[0, -1]])
    assert (found <= 0.25 * SCALE * LIMITS).all()


def jump_at_full_speed(path):
    """The largest change of a joint's speed if nothing slowed down."""
    steps = np.diff(path, axis=0)
    steps = steps[np.abs(steps).max(axis=1) > 1e-6]
    durations = (np.abs(steps) / (SCALE * LIMITS)).max(axis=1)
    return np.abs(np.diff(steps / durations[:, None], axis=0)).max(initial=0.0)


@QUICK
@given(PATHS)
def test_slows_down_at_corners(path):
    """Between two rows the speed changes much less than it would, however sharp the corner."""
    assume(long_enough(path))
    jump = jump_at_full_speed(path)
    assume(jump > 1.5)
    changes = np.abs(np.diff(speeds(time_path(path, LIMITS, scale=SCALE)), axis=0))
    assert changes.max() <= max(0.45 * (SCALE * LIMITS).max(), 0.25 + 0.3 * jump)


def test_jump_of_speed_at_a_reversal():
    path = np.array([[0.0, 0, 0], [1.0, 0, 0], [0.0, 0, 0]])
    changes = np.diff(speeds(time_path(path, LIMITS, scale=SCALE)), axis=0)
    assert np.abs(changes).max() <= 0.5 + 1e-6


@QUICK
@given(PATHS)
def test_speed_builds_up_steadily(path):
    """On the way from one end of a straight line to the other, in a fifth of a second."""
    line = path[[0, -1]]
    assume(long_enough(line))
    trajectory = time_path(line, LIMITS, scale=SCALE)
    share = np.abs(speeds(trajectory) / (SCALE * LIMITS)).max(axis=1)
    middle = (trajectory.times[1:] + trajectory.times[:-1]) / 2.0
    assert (np.abs(np.diff(share)) <= np.diff(middle) / 0.2 + 1e-6).all()


def test_corners_can_be_gentler():
    bent = np.array([[0.0, 0, 0], [0.5, 0.3, 0], [0.0, 0.6, 0.2]])
    for corner_jump in (0.45, 0.1):
        result = time_path(bent, LIMITS, scale=SCALE, corner_jump=corner_jump)
        speeds = np.diff(result.positions, axis=0) / np.diff(result.times)[:, None]
        corner = int(np.argmin(np.abs(result.positions - bent[1]).max(axis=1)))
        assert np.abs(speeds[corner] - speeds[corner - 1]).max() <= corner_jump + 0.1


def test_a_corner_takes_time():
    straight = np.array([[0.0, 0, 0], [0.5, 0, 0], [1.0, 0, 0]])
    bent = np.array([[0.0, 0, 0], [0.5, 0, 0], [0.0, 0, 0]])
    quick = time_path(straight, LIMITS, scale=SCALE).duration
    assert quick == pytest.approx(1.2, abs=0.01)  # 1 rad at 1 rad/s, and the ramps
    assert time_path(bent, LIMITS, scale=SCALE).duration > quick + 0.05


def test_standing_still_is_one_row():
    for path in (np.zeros((1, 3)), np.zeros((4, 3))):
        trajectory = time_path(path, LIMITS, scale=SCALE)
        assert (trajectory.times.tolist(), trajectory.positions.shape) == ([0.0], (1, 3))


def test_repeated_waypoints_are_dropped():
    once = np.array([[0.0, 0, 0], [0.5, 0.2, 0], [1.0, 0, 0]])
    twice = np.repeat(once, 2, axis=0)
    a, b = (time_path(path, LIMITS, scale=SCALE) for path in (once, twice))
    np.testing.assert_allclose(a.times, b.times)


@pytest.mark.parametrize("length", [1e-4, 0.005, 0.015])
def test_a_very_short_path(length):
    path = np.array([[0.0, 0, 0], [length, 0, 0]])
    trajectory = time_path(path, LIMITS, scale=SCALE)
    assert 0.0 < trajectory.duration < 0.3
    assert (np.abs(speeds(trajectory)) <= SCALE * LIMITS).all()


@QUICK
@given(PATHS, st.floats(0.01, 1.0))
def test_interpolation_keeps_waypoints_and_step(path, step):
    rows = interpolated(path, step)
    assert (np.abs(np.diff(rows, axis=0)) <= step + 1e-9).all()
    for waypoint in path:
        assert np.abs(rows - waypoint).max(axis=1).min() < 1e-9
    assert np.array_equal(rows[0], path[0])


LENGTHS = st.lists(st.floats(1e-6, 1.5), min_size=1, max_size=6)


@QUICK
@given(LENGTHS)
def test_a_piece_is_cut_the_same_beside_others(lengths):
    progress = np.concatenate([[0.0], np.cumsum(lengths)])
    grid = _cut(progress)
    pieces = [_cut(progress[k : k + 2]) for k in range(len(lengths))]
    assert np.array_equal(grid, np.concatenate(pieces))
    for start, end, piece in zip(progress, progress[1:], pieces, strict=False):
        assert piece[0] == start
        assert (np.diff(np.append(piece, end)) <= 0.02 + 1e-9).all()
        assert (np.diff(np.append(piece, end)) > 0.0).all()


@QUICK
@given(st.lists(st.tuples(st.sampled_from([0.0, 0.1, 0.5, 1.0, 1.0]), st.floats(1e-3, 0.4))))
def test_speeds_are_lowered_no_more_than_needed(rows):
    squares = [0.0, *(square for square, _ in rows)]
    gaps = [gap for _, gap in rows]
    expected = [0.0]
    for square, gap in zip(squares[1:], gaps, strict=True):
        expected.append(min(square, expected[-1] + gap))
    assert _limited(squares, gaps) == expected
