"""The compiled chain agrees with numpy, with finite differences and with itself."""

from dataclasses import replace

import numpy as np
import pytest
from mamo_geometry.kinematics import ChainKinematics
from mamo_geometry.options import KinematicsOptions

from mamo_core.problems import generate_shelf
from mamo_core.robots import load_arm
from mamo_core.robots.kinematics import tool_transform
from mamo_core.types.geometry import make_pose, matrix_from_pose, tool_matrix

ARMS = ["pr2_right_arm", "panda"]
BASE = make_pose([0.3, -0.2, 0.1], yaw=0.7)


def chain(name, base=BASE):
    arm = load_arm(name)
    scene = replace(generate_shelf(movables=0, seed=1).scene, robot=name, T_world_base=base)
    return arm, ChainKinematics(scene, arm, KinematicsOptions())


def random_configurations(arm, count, seed=0):
    rng = np.random.default_rng(seed)
    low, high = arm.around_home
    return rng.uniform(low, high, (count, arm.dof))


def angle_between(A, B):
    """Angle (rad) between two rotations, accurate when it is small."""
    return np.linalg.norm(A[:3, :3] - B[:3, :3]) / np.sqrt(2.0)


@pytest.mark.parametrize("name", ARMS)
def test_forward_agrees_with_numpy(name):
    arm, kinematics = chain(name)
    for q in random_configurations(arm, 100):
        expected = matrix_from_pose(BASE) @ tool_transform(arm, q)
        np.testing.assert_allclose(kinematics.forward(q), expected, atol=1e-12)


@pytest.mark.parametrize("name", ARMS)
def test_jacobian_agrees_with_finite_differences(name):
    arm, kinematics = chain(name)
    h = 1e-6
    for q in random_configurations(arm, 20, seed=1):
        J = kinematics.jacobian(q)
        for j in range(arm.dof):
            step = np.zeros(arm.dof)
            step[j] = h
            ahead, behind = kinematics.forward(q + step), kinematics.forward(q - step)
            np.testing.assert_allclose(
                J[:3, j], (ahead - behind)[:3, 3] / (2 * h), atol=1e-7, rtol=0
            )
            W = (ahead[:3, :3] @ behind[:3, :3].T - np.eye(3)) / (2 * h)
            spin = [W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]]
            np.testing.assert_allclose(J[3:, j], np.array(spin) / 2, atol=1e-7, rtol=0)


@pytest.mark.parametrize("name", ARMS)
def test_inverse_reaches_within_limits_by_distinct_solutions(name):
    arm, kinematics = chain(name)
    rng = np.random.default_rng(2)
    solved = several = 0
    for q in random_configurations(arm, 40, seed=3):
        T = kinematics.forward(q)
        solutions = kinematics.inverse(T, rng, count=4)
        assert solutions.shape[0] <= 4
        solved += len(solutions) > 0
        several += len(solutions) > 1
        for i, solution in enumerate(solutions):
            assert arm.within_limits(solution)
            reached = kinematics.forward(solution)
            assert np.linalg.norm(reached[:3, 3] - T[:3, 3]) < 1e-4
            assert angle_between(reached, T) < 2e-4
            for other in solutions[:i]:
                assert np.abs(solution - other).max() >= 0.3
    assert solved >= 36
    assert several >= 25


def test_a_seed_near_the_goal_is_the_first_solution():
    arm, kinematics = chain("pr2_right_arm")
    for q in random_configurations(arm, 10, seed=4):
        T = kinematics.forward(q)
        found = kinematics.inverse(T, np.random.default_rng(0), count=1, near=q)
        np.testing.assert_allclose(found[0], q, atol=1e-9)


def test_turns_of_continuous_joints_end_near_home():
    arm, kinematics = chain("pr2_right_arm")
    rng = np.random.default_rng(5)
    wide = arm.upper - arm.lower > 2.0 * np.pi
    assert wide.sum() == 2
    for q in random_configurations(arm, 10, seed=6):
        for solution in kinematics.inverse(kinematics.forward(q), rng, count=4):
            assert (np.abs(solution - arm.home)[wide] <= np.pi + 1e-9).all()


def test_out_of_reach_has_no_solution():
    arm, kinematics = chain("pr2_right_arm")
    found = kinematics.inverse(tool_matrix([5.0, 0.0, 1.0], 0.0), np.random.default_rng(0), count=3)
    assert found.shape == (0, arm.dof)


def test_same_generator_same_solutions():
    arm, kinematics = chain("pr2_right_arm")
    T = kinematics.forward(random_configurations(arm, 1, seed=7)[0])
    a, b = (kinematics.inverse(T, np.random.default_rng(9), count=4) for _ in range(2))
    assert np.array_equal(a, b)


@pytest.mark.parametrize("direction", [(0.15, 0, 0), (0, -0.12, 0), (0.08, 0.08, 0.05)])
def test_lines_are_straight(direction):
    arm, kinematics = chain("pr2_right_arm", make_pose([0.0, 0.0, 0.0]))
    rng = np.random.default_rng(1)
    followed = 0
    for y in (-0.6, -0.45, -0.3):
        T = tool_matrix([0.62, y, 0.86], 0.1, 0.3)
        T_end = T.copy()
        T_end[:3, 3] += direction
        unit = np.array(direction) / np.linalg.norm(direction)
        for q in kinematics.inverse(T, rng, count=2):
            line = kinematics.follow_line(q, T_end)
            assert np.array_equal(line.path[0], q)
            rows = line.path
            between = (rows[1:] + rows[:-1]) / 2.0  # what is executed between two rows
            for row in (*rows, *between):
                T_row = kinematics.forward(row)
                off = T_row[:3, 3] - T[:3, 3]
                assert np.linalg.norm(off - (off @ unit) * unit) < 1e-3
                assert angle_between(T_row, T) < 5e-3
                assert arm.within_limits(row)
            assert (np.abs(np.diff(rows, axis=0)) <= 0.25).all()
            reached = kinematics.forward(rows[-1])[:3, 3]
            expected = T[:3, 3] + line.fraction * np.array(direction)
            np.testing.assert_allclose(reached, expected, atol=1e-4)
            followed += line.fraction == 1.0
    assert followed >= 3


def test_a_line_out_of_reach_stops_on_the_way():
    _, kinematics = chain("pr2_right_arm", make_pose([0.0, 0.0, 0.0]))
    T = tool_matrix([0.7, -0.45, 0.86], 0.0)
    q = kinematics.inverse(T, np.random.default_rng(0), count=1)[0]
    T_end = T.copy()
    T_end[0, 3] += 1.5
    line = kinematics.follow_line(q, T_end)
    assert 0.0 < line.fraction < 0.5
    reached = kinematics.forward(line.path[-1])[:3, 3]
    np.testing.assert_allclose(reached, T[:3, 3] + [1.5 * line.fraction, 0, 0], atol=1e-4)


def test_a_line_may_turn():
    _, kinematics = chain("pr2_right_arm", make_pose([0.0, 0.0, 0.0]))
    T, T_end = tool_matrix([0.62, -0.45, 0.86], 0.0), tool_matrix([0.66, -0.45, 0.86], 0.4)
    q = kinematics.inverse(T, np.random.default_rng(0), count=1)[0]
    line = kinematics.follow_line(q, T_end)
    assert line.fraction == 1.0
    assert angle_between(kinematics.forward(line.path[-1]), T_end) < 1e-3
    half = kinematics.forward(line.path[len(line.path) // 2])
    share = (len(line.path) // 2) / (len(line.path) - 1)
    assert angle_between(half, tool_matrix([0, 0, 0], 0.4 * share)) < 1e-3
