"""Executes a plan with recording engines, or puts executions of it on one grid."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.recording.tracks import Tracks, align
from mamo_core.robots.model import ArmModel
from mamo_core.types.problem import Problem
from mamo_core.types.recording import RecordedExecution, Recording
from mamo_core.types.rollout import RolloutResult, Violation
from mamo_core.types.solution import Plan
from mamo_core.verify import VerifyReport, verify

STEP = 0.02
"""Time between the rows of a recording, s: 50 pictures a second."""


def record(
    problem: Problem,
    plan: Plan,
    models: Mapping[str, TransitionModel],
    robot: ArmModel,
    step: float = STEP,
) -> Recording:
    """Verify the plan in every engine and keep what happened.

    Raises:
        ValueError: no engine gave a recording: the plan is malformed, or all were lost.
    """
    reports = {
        name: verify(problem, plan, model, robot, trace_step=step) for name, model in models.items()
    }
    return recording_of(problem, plan, reports)


def recording_of(problem: Problem, plan: Plan, reports: Mapping[str, VerifyReport]) -> Recording:
    """The recorded rollouts of verifications, on one grid; engines that were lost are left out.

    Raises:
        ValueError: none of the reports holds a recorded rollout.
    """
    rollouts = {
        name: report.rollout
        for name, report in reports.items()
        if report.rollout is not None and report.rollout.trace is not None and not report.lost
    }
    if not rollouts:
        words = [f"{name}: {'; '.join(report.failures)}" for name, report in reports.items()]
        raise ValueError(f"no engine executed the plan: {', '.join(words)}")
    tracks = align(rollouts)
    executions = tuple(
        RecordedExecution(
            engine=name,
            joints=tracks.joints[name],
            openings=tracks.openings[name],
            poses=tracks.poses[name],
            contacts=tracks.contacts[name],
            violations=tuple(_moved(v, rollout, tracks) for v in rollout.violations),
            failures=reports[name].failures,
        )
        for name, rollout in rollouts.items()
    )
    return Recording(problem, plan, tracks.times, tracks.segments, executions)


def _moved(violation: Violation, rollout: RolloutResult, tracks: Tracks) -> Violation:
    """The violation at its time on the common grid: as long after the start of its segment."""
    starts = np.asarray(rollout.segment_times)
    number = max(int(np.searchsorted(starts, violation.time, side="right")) - 1, 0)
    rows = np.flatnonzero(tracks.segments == number)
    if not len(rows):  # after the end of the grid, which is where another engine stopped
        return replace(violation, time=float(tracks.times[-1]))
    time = float(tracks.times[rows[0]] + violation.time - starts[number])
    return replace(violation, time=min(time, float(tracks.times[rows[-1]])))
