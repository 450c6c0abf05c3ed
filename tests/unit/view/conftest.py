"""Recordings written down by hand: a gantry that pushes a can, in one engine or in two."""

from dataclasses import replace

import numpy as np
import pytest

from mamo_core.testing.transition_cases import gantry_cases
from mamo_core.types.action import RearrangementAction
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.recording import RecordedExecution, Recording
from mamo_core.types.region import SweptRegion
from mamo_core.types.solution import Plan

STEP = 0.1
ROWS = 20
CASES = gantry_cases()
PROBLEM = CASES.problem


@pytest.fixture
def execution():
    """``execution("a", sideways=0.01)``: the can moves along x, and so far (m) along y."""

    def execution(engine, sideways=0.0, violations=(), failures=()):
        poses = np.repeat(PROBLEM.initial.object_poses[None], ROWS, axis=0)
        along = np.linspace(0.0, 1.0, ROWS)
        poses[:, 0, 0] += 0.1 * along
        poses[:, 0, 1] += sideways * along
        entities = len(PROBLEM.scene.entities)
        return RecordedExecution(
            engine,
            joints=np.linspace([0.5, -0.45, 0.8, 0.0], [0.6, -0.45, 0.9, 0.5], ROWS),
            openings=np.zeros(ROWS),
            poses=poses,
            contacts=np.zeros((ROWS, entities, entities), dtype=bool),
            violations=violations,
            failures=failures,
        )

    return execution


@pytest.fixture
def recording(execution):
    """``recording(execution("a"), ...)``: of a push and a retrieval, two segments each."""

    def recording(*executions):
        can = PROBLEM.initial.object_poses[0, :2]
        path = np.array([can, can + np.array([0.1, 0.0])])
        lowest = np.full((20, 30), np.inf)
        lowest[:10, 5:15], lowest[10:12, 8] = 0.8, 0.7
        region = SweptRegion(np.array([0.5, -0.6]), 0.01, lowest, 0.77)
        plan = Plan((RearrangementAction("push", "can", CASES.push, path),), CASES.push, region)
        segments = np.repeat(np.arange(4), ROWS // 4)
        times = STEP * np.arange(ROWS)
        return Recording(PROBLEM, plan, times, segments, executions or (execution("a"),))

    return recording


@pytest.fixture
def panda(recording, execution):
    """One whose robot a file can name; its arm rests."""
    still = replace(execution("a"), joints=np.zeros((ROWS, 7)))
    scene = replace(PROBLEM.scene, robot="panda")
    initial = PROBLEM.initial.with_joints(np.zeros(7))
    problem = replace(PROBLEM, scene=scene, initial=initial, home=np.zeros(7))
    rest = Trajectory.still(np.zeros(7), 1.0)
    motion = Motion((MotionSegment(SegmentKind.TRANSIT, rest, 0.0),) * 2, 0.0)
    shown = recording(still)
    actions = tuple(replace(action, motion=motion) for action in shown.plan.actions)
    plan = replace(shown.plan, actions=actions, retrieval=motion)
    return replace(shown, problem=problem, plan=plan)
