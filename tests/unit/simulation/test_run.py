"""How a motion is executed does not depend on how far an engine goes before it is looked at."""

from dataclasses import replace

import numpy as np
import pytest

from mamo_core.interfaces.simulated_world import SimulatedWorld
from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.simulation.run import LAG, MotionRun
from mamo_core.testing.gantry_arm import gantry_arm
from mamo_core.testing.transition_cases import gantry_cases, standard_constraints
from mamo_core.types.motion import Motion
from mamo_core.types.rollout import NO_CONTACTS, NO_DEPTHS, StepObservation

LATE = 1.1 * LAG


class ScriptedWorld(SimulatedWorld):
    """Nothing moves but the arm, which is ``gaps[k]`` behind after step k, and no longer then."""

    time_step = 0.004

    def __init__(self, problem, gaps):
        self._initial, self._gaps = problem.initial, gaps
        self._end, self.steps, self._objects = problem.home, 0, len(problem.scene.objects)

    def reset(self, state, drive):
        raise NotImplementedError

    def command(self, positions, velocities, drive):
        self._end = positions

    def step(self):
        self.steps += 1

    def observe(self, time, held):
        z = np.tile([0.0, 0.0, 1.0], (self._objects, 1))
        positions = self._initial.object_poses[:, :3].copy()
        return StepObservation(time, positions, z, np.zeros_like(z), NO_CONTACTS, NO_DEPTHS, held)

    def joint_positions(self):
        behind = self._gaps[self.steps - 1] if 0 < self.steps <= len(self._gaps) else 0.0
        return self._end - behind

    def tool_pose(self):
        raise NotImplementedError

    def object_poses(self):
        return self._initial.object_poses.copy()

    def at_rest(self, speed, spin):
        return True

    def hold(self, place):
        raise NotImplementedError


class HastyWorld(ScriptedWorld):
    """Passes over all steps it may."""

    def follow(self, positions, velocities, drives, watch):
        for row in range(len(positions)):
            super().follow(positions[row:], velocities[row:], drives[row:], watch)
            if np.abs(self.joint_positions() - positions[row]).max() > watch.lag:
                break
        return row + 1


@pytest.fixture(scope="module")
def still():
    """A problem, and half a second in which the arm should not move."""
    cases = gantry_cases()
    motion = Motion(tuple(replace(s, settle=0.0) for s in cases.still.segments), 0.0)
    return cases.problem, motion


@pytest.fixture(params=[ScriptedWorld, HastyWorld])
def executed(request, still):
    """``executed(gaps)``: the result."""
    problem, motion = still

    def run(gaps):
        world = request.param(problem, gaps)
        constraints, gripper = standard_constraints(problem), gantry_arm().gripper
        one = MotionRun(world, problem.scene, gripper, constraints, RolloutOptions(), 0.0)
        result = one.execute(motion, problem.initial)
        assert result.steps == world.steps
        return result

    return run


def test_an_arm_that_is_late_for_long_stalls(executed):
    result = executed([0.0] * 10 + [LATE] * 60)
    assert result.stalled
    assert result.steps == 10 + 25
    assert result.duration == pytest.approx(0.14)


def test_an_arm_that_is_late_now_and_then_does_not(executed):
    for on_time in (1, 2, 10):
        result = executed(([LATE] * 24 + [0.0] * on_time) * 3)
        assert not result.stalled
        assert result.steps >= 125
