"""Recordings of executions written down by hand: what they hold, and that files give it back."""

from dataclasses import replace

import numpy as np
import pytest

from mamo_core.errors import InputError
from mamo_core.recording import read_recording, recording_of, write_recording
from mamo_core.testing.transition_cases import gantry_cases
from mamo_core.types.action import RearrangementAction
from mamo_core.types.rollout import RolloutResult, Trace, Violation
from mamo_core.types.solution import Plan
from mamo_core.verify import VerifyReport

STEP = 0.1
CASES = gantry_cases()
PROBLEM = CASES.problem
PUSH = CASES.push
PLAN = Plan((RearrangementAction("push", "can", PUSH, np.zeros((2, 2))),), PUSH)
TIPPED = Violation("tilt", "can", None, 1.25, 0.6, 0.4)


def verified(durations, *violations, failures=()):
    """The report of an execution whose segments took these times (s)."""
    starts = np.concatenate([[0.0], np.cumsum(durations)])
    times = STEP * np.arange(round(starts[-1] / STEP) + 1)
    poses = np.repeat(PROBLEM.initial.object_poses[None], len(times), axis=0)
    entities = len(PROBLEM.scene.entities)
    contacts = np.zeros((len(times), entities, entities), dtype=bool)
    trace = Trace(times, np.zeros((len(times), 4)), np.zeros(len(times)), poses, contacts)
    rollout = RolloutResult(
        final_state=PROBLEM.initial,
        violations=violations,
        moved=(),
        contacts=frozenset(),
        stalled=False,
        duration=float(starts[-1]),
        steps=0,
        segment_times=tuple(starts[:-1]),
        trace=trace,
    )
    return VerifyReport(failures, rollout)


def test_a_violation_keeps_its_distance_from_the_start_of_its_segment():
    """In the slower engine's time: its first segment takes 0.6 s longer."""
    reports = {"slow": verified([1.6, 0.5]), "quick": verified([1.0, 0.5], TIPPED)}
    recording = recording_of(PROBLEM, PLAN, reports)
    (violation,) = recording.executions[1].violations
    assert violation.time == pytest.approx(1.25 + 0.6)
    assert violation.subject == "can"


def test_a_violation_after_the_end_stands_at_the_end():
    reports = {"stopped": verified([1.0]), "other": verified([1.0, 0.5], TIPPED)}
    recording = recording_of(PROBLEM, PLAN, reports)
    assert recording.executions[1].violations[0].time == recording.times[-1]


def test_stretches_name_the_motion_they_belong_to():
    """Two motions, each of all the segments of the push."""
    count = len(PUSH.segments)
    recording = recording_of(PROBLEM, PLAN, {"a": verified([0.5] * (2 * count))})
    assert [s.motion for s in recording.stretches] == [0] * count + [1] * count
    assert [s.kind for s in recording.stretches] == 2 * [str(s.kind) for s in PUSH.segments]
    assert [(s.first, s.last) for s in recording.stretches[:2]] == [(0, 4), (5, 9)]
    assert [recording.title(i) for i in (0, 1)] == ["push can", "retrieve"]


def test_an_engine_that_was_lost_is_left_out():
    whole = verified([1.0])
    lost = replace(whole, rollout=replace(whole.rollout, lost="it hung"), failures=("it hung",))
    recording = recording_of(PROBLEM, PLAN, {"lost": lost, "whole": whole})
    assert [e.engine for e in recording.executions] == ["whole"]
    with pytest.raises(ValueError, match="lost: it hung"):
        recording_of(PROBLEM, PLAN, {"lost": lost})


def test_a_file_gives_the_recording_back(tmp_path):
    reports = {"a": verified([1.0, 0.5], TIPPED, failures=("it tipped",)), "b": verified([1, 0.5])}
    problem = replace(PROBLEM, scene=replace(PROBLEM.scene, robot="panda"))  # files know no gantry
    recording = recording_of(problem, PLAN, reports)
    write_recording(tmp_path / "kept.npz", recording)
    again = read_recording(tmp_path / "kept.npz")
    assert (again.times == recording.times).all()
    assert (again.segments == recording.segments).all()
    assert again.problem.name == PROBLEM.name
    assert [a.object_name for a in again.plan.actions] == ["can"]
    for one, other in zip(recording.executions, again.executions, strict=True):
        assert one.engine == other.engine
        assert one.violations == other.violations
        assert one.failures == other.failures
        for track in ("joints", "openings", "poses", "contacts"):
            assert (getattr(one, track) == getattr(other, track)).all()


def test_what_is_no_recording_is_refused(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_recording(tmp_path / "absent.npz")
    (tmp_path / "text.npz").write_text("something else")
    with pytest.raises(InputError, match="not a recording"):
        read_recording(tmp_path / "text.npz")
    np.savez(tmp_path / "arrays.npz", times=np.zeros(3))
    with pytest.raises(InputError, match="not a recording"):
        read_recording(tmp_path / "arrays.npz")
