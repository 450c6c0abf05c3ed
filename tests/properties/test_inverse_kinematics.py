"""Inverse kinematics keeps joint limits, whatever their range."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mamo_geometry.ik_kernels import _turned_home
from mamo_geometry.kinematics import ChainKinematics
from mamo_geometry.options import KinematicsOptions

from mamo_core.robots.library import load_arm
from mamo_core.testing.transition_cases import pr2_cases

QUICK = settings(max_examples=200, deadline=None, derandomize=True)
ANGLES = st.floats(-13.0, 13.0)


@QUICK
@given(st.tuples(ANGLES, ANGLES).map(sorted), st.floats(0.0, 1.0), ANGLES)
def test_turns_stay_within_limits_and_are_the_nearest(limits, share, home):
    lower, upper = limits
    assume(upper - lower > 2.0 * np.pi and lower <= home <= upper)
    angle = lower + share * (upper - lower)
    turned = _turned_home(angle, home, lower, upper)
    assert lower - 1e-9 <= turned <= upper + 1e-9
    assert np.cos(turned - angle) == pytest.approx(1.0)
    choices = angle + 2.0 * np.pi * np.arange(-5, 6)
    inside = choices[(choices >= lower) & (choices <= upper)]
    assert abs(turned - home) <= np.abs(inside - home).min() + 1e-9


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 2**31), st.floats(3.3, 9.0), st.floats(-2.5, 2.5))
def test_solutions_are_within_odd_ranges(seed, half, middle):
    """The forearm's and the wrist's rolls get a range somewhere around home."""
    arm = load_arm("pr2_right_arm")
    lower, upper, home = np.array(arm.lower), np.array(arm.upper), np.array(arm.home)
    for joint in (4, 6):
        lower[joint], upper[joint] = middle - half, middle + half
        home[joint] = np.clip(home[joint], lower[joint], upper[joint])
    odd = replace(arm, lower=lower, upper=upper, home=home)
    kinematics = ChainKinematics(pr2_cases().problem.scene, odd, KinematicsOptions())
    rng = np.random.default_rng(seed)
    goal = kinematics.forward(rng.uniform(*odd.around_home))
    near = rng.uniform(lower - 1.0, upper + 1.0)
    for q in kinematics.inverse(goal, rng, count=6, near=near):
        assert odd.within_limits(q)
