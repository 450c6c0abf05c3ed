"""Many transforms at once are the same as one after the other."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mamo_core.types.geometry import (
    matrices_from_poses,
    matrix_from_pose,
    rotation_from_quat,
    rotations_from_quats,
    tool_matrices,
    tool_matrix,
)

QUICK = settings(max_examples=60, deadline=None, derandomize=True)
COUNTS = st.integers(1, 6)
NUMBERS = st.floats(-3.0, 3.0).filter(lambda x: abs(x) > 1e-3)


def rows(width):
    return COUNTS.flatmap(lambda n: arrays(np.float64, (n, width), elements=NUMBERS))


@QUICK
@given(rows(7))
def test_poses(poses):
    expected = [matrix_from_pose(pose) for pose in poses]
    np.testing.assert_allclose(matrices_from_poses(poses), expected, rtol=0, atol=1e-15)
    rotations = [rotation_from_quat(pose[3:]) for pose in poses]
    np.testing.assert_allclose(rotations_from_quats(poses[:, 3:]), rotations, rtol=0, atol=1e-15)


@QUICK
@given(rows(4))
def test_rotations_keep_lengths_and_hands(quats):
    R = rotations_from_quats(quats)
    np.testing.assert_allclose(R @ R.swapaxes(1, 2), np.tile(np.eye(3), (len(R), 1, 1)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(R), 1.0)


@QUICK
@given(rows(5))
def test_tools(values):
    positions, yaws, pitches = values[:, :3], values[:, 3], values[:, 4]
    found = tool_matrices(positions, yaws, pitches)
    for T, position, yaw, pitch in zip(found, positions, yaws, pitches, strict=True):
        np.testing.assert_array_equal(T, tool_matrix(position, yaw, pitch))
        ahead = [np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), -np.sin(pitch)]
        np.testing.assert_allclose(T[:3, 0], ahead, atol=1e-15)
        np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-12)
        np.testing.assert_array_equal(T[:, 3], [*position, 1.0])


def test_none_at_all():
    assert matrices_from_poses(np.zeros((0, 7))).shape == (0, 4, 4)
    assert tool_matrices(np.zeros((0, 3)), np.zeros(0), np.zeros(0)).shape == (0, 4, 4)
