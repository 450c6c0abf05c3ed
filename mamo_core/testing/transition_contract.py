"""What every transition model must do; subclass it to test yours.

::

    from mamo_core.testing.transition_contract import TransitionModelContract

    class TestMyEngine(TransitionModelContract):
        capabilities = frozenset({"exact_continuation"})

        def make_model(self, problem):
            return MyEngine(problem, standard_constraints(problem))

The default cases move the PR2's right arm; override ``make_cases`` for another robot.
"""

from __future__ import annotations

import numpy as np
import pytest

from mamo_core.interfaces.transition_model import RolloutOptions, TransitionModel
from mamo_core.testing.transition_cases import TransitionCases, merged, pr2_cases, shift_along
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import SceneState, displacements

JOINT_TOLERANCE = 0.05
"""How far the arm may lag behind at the end, rad (or m)."""

REST_TOLERANCE = 0.001
"""Objects that nobody touches stay within this, m."""

HEAVIER, ROUGHER = 120.0, 3.0
"""Factors of the overridden mass and friction."""

MOVED = 0.01
LONGEST_PUSH = 0.15

ALL = RolloutOptions(stop_early=False)


class TransitionModelContract:
    """Pytest collects it through your subclass; each test states one promise."""

    capabilities: frozenset[str] = frozenset()
    """What the model declares, as in ``Component.provides``."""

    def make_model(self, problem: Problem) -> TransitionModel:
        """A new model with contact, tilt, speed and bounds constraints."""
        raise NotImplementedError("override make_model(problem)")

    def make_cases(self) -> TransitionCases:
        """The problem and the motions; by default those of the PR2's right arm."""
        return pr2_cases()

    @pytest.fixture
    def cases(self) -> TransitionCases:
        return self.make_cases()

    @pytest.fixture
    def model(self, cases: TransitionCases) -> TransitionModel:
        return self.make_model(cases.problem)

    def test_same_arguments_give_the_same_result(
        self, model: TransitionModel, cases: TransitionCases
    ) -> None:
        start = cases.problem.initial
        assert_same(model.rollout(start, cases.push), model.rollout(start, cases.push))

    def test_history_does_not_matter(self, model: TransitionModel, cases: TransitionCases) -> None:
        start = cases.problem.initial
        first = model.rollout(start, cases.push)
        model.rollout(start, cases.crash, options=ALL)
        model.rollout(first.final_state, cases.push)
        assert_same(first, model.rollout(start, cases.push))

    def test_a_new_model_gives_the_same_result(
        self, model: TransitionModel, cases: TransitionCases
    ) -> None:
        start = cases.problem.initial
        model.rollout(start, cases.crash)
        other = self.make_model(cases.problem)
        assert_same(model.rollout(start, cases.push), other.rollout(start, cases.push))

    def test_arguments_are_left_alone(self, model: TransitionModel, cases: TransitionCases) -> None:
        start = cases.problem.initial
        poses, joints = start.object_poses.copy(), start.joint_positions.copy()
        model.rollout(start, cases.push)
        assert np.array_equal(start.object_poses, poses), "the initial poses were changed"
        assert np.array_equal(start.joint_positions, joints), "the initial joints were changed"

    def test_nothing_moves_while_the_arm_rests(
        self, model: TransitionModel, cases: TransitionCases
    ) -> None:
        start = cases.problem.initial
        result = model.rollout(start, cases.still)
        shifts = displacements(start, result.final_state)
        assert shifts.max() < REST_TOLERANCE, f"objects moved by {shifts.tolist()} m"
        assert result.moved == ()
        assert result.valid, f"stalled: {result.stalled}, {[str(v) for v in result.violations]}"

    def test_final_state_is_complete(self, model: TransitionModel, cases: TransitionCases) -> None:
        start = cases.problem.initial
        final = model.rollout(start, cases.push).final_state
        assert final.object_poses.shape == start.object_poses.shape
        assert final.joint_positions.shape == start.joint_positions.shape
        norms = np.linalg.norm(final.object_poses[:, 3:], axis=1)
        np.testing.assert_allclose(norms, 1.0, atol=1e-6, err_msg="quaternions of unit length")

    def test_the_arm_arrives(self, model: TransitionModel, cases: TransitionCases) -> None:
        result = model.rollout(cases.problem.initial, cases.push)
        assert not result.stalled
        lag = np.abs(result.final_state.joint_positions - cases.push.end).max()
        assert lag < JOINT_TOLERANCE, f"the arm ends {lag:.3f} rad from the motion's end"

    def test_a_push_moves_what_it_meets(
        self, model: TransitionModel, cases: TransitionCases
    ) -> None:
        start = cases.problem.initial
        result = model.rollout(start, cases.push)
        place = cases.problem.scene.index(cases.pushed)
        poses = (start.object_poses[place], result.final_state.object_poses[place])
        shift = shift_along(*poses, np.array(cases.direction))
        assert 2 * MOVED < shift < LONGEST_PUSH, f"{cases.pushed} moved by {shift:.3f} m"
        assert ("robot", cases.pushed) in result.contacts
        assert result.valid, f"stalled: {result.stalled}, {[str(v) for v in result.violations]}"

    def test_moved_names_what_moved(self, model: TransitionModel, cases: TransitionCases) -> None:
        start = cases.problem.initial
        result = model.rollout(start, cases.push)
        shifts = displacements(start, result.final_state)
        names = [item.name for item in cases.problem.scene.objects]
        expected = [name for name, shift in zip(names, shifts, strict=True) if shift > MOVED]
        assert sorted(result.moved) == sorted(expected) == [cases.pushed]

    def test_a_crash_is_a_contact_violation(
        self, model: TransitionModel, cases: TransitionCases
    ) -> None:
        result = model.rollout(cases.problem.initial, cases.crash)
        assert not result.valid
        assert result.violations, "the crash broke no constraint"
        first = result.violations[0]
        assert first.constraint == "contact", str(first)
        assert {first.subject, first.other} == {cases.pushed, cases.hit}, str(first)
        assert any({cases.pushed, cases.hit} == set(pair) for pair in result.contacts)

    def test_violations_come_in_time_order(
        self, model: TransitionModel, cases: TransitionCases
    ) -> None:
        result = model.rollout(cases.problem.initial, cases.crash, options=ALL)
        times = [violation.time for violation in result.violations]
        assert len(set(times)) > 1, f"expected one violation after the other, got {times}"
        assert times == sorted(times)
        assert 0.0 <= times[0] <= times[-1] <= result.duration + 1e-9

    def test_early_stop_ends_at_the_first_violation(
        self, model: TransitionModel, cases: TransitionCases
    ) -> None:
        start = cases.problem.initial
        early = model.rollout(start, cases.crash)
        full = model.rollout(start, cases.crash, options=ALL)
        assert early.violations[0] == full.violations[0]
        assert {v.time for v in early.violations} == {early.violations[0].time}
        assert early.duration <= early.violations[0].time + 0.1, "the rollout went on"
        assert not full.stalled, "the crash stalls the arm: the case cannot tell who stopped"
        assert full.duration >= cases.crash.duration - 1e-6, "asked not to stop, but it did"

    def test_a_batch_is_a_loop(self, model: TransitionModel, cases: TransitionCases) -> None:
        start = cases.problem.initial
        motions = [cases.push, cases.still, cases.crash, cases.push]
        overrides = [None, None, None, _overrides(cases)]
        batch = model.rollout_batch([start] * 4, motions, parameters=overrides)
        assert len(batch) == len(motions)
        for result, motion, override in zip(batch, motions, overrides, strict=True):
            assert_same(model.rollout(start, motion, parameters=override), result)

    def test_overrides_change_the_outcome(
        self, model: TransitionModel, cases: TransitionCases
    ) -> None:
        start = cases.problem.initial
        nominal = model.rollout(start, cases.push)
        heavy = model.rollout(start, cases.push, parameters=_overrides(cases))
        assert not same(nominal, heavy), "masses and frictions had no effect at all"

    def test_overrides_leave_nothing_behind(
        self, model: TransitionModel, cases: TransitionCases
    ) -> None:
        start = cases.problem.initial
        before = model.rollout(start, cases.push)
        model.rollout(start, cases.push, parameters=_overrides(cases))
        assert_same(before, model.rollout(start, cases.push))

    def test_segment_states_are_the_starts_of_segments(
        self, model: TransitionModel, cases: TransitionCases
    ) -> None:
        start = cases.problem.initial
        result = model.rollout(start, cases.push)
        states = result.segment_states
        assert len(states) == len(cases.push.segments)
        shifts = displacements(start, states[0])
        assert shifts.max() < REST_TOLERANCE, "the first segment starts at the given state"
        for state, segment in zip(states, cases.push.segments, strict=True):
            lag = np.abs(state.joint_positions - segment.trajectory.positions[0]).max()
            assert lag < JOINT_TOLERANCE, f"{segment.kind} starts {lag:.3f} rad off"
        place = cases.problem.scene.index(cases.pushed)
        swept = displacements(start, states[1])[place]
        assert swept > MOVED, "the second segment starts after the sweep"
        cut = model.rollout(start, cases.crash)
        assert len(cut.segment_states) == 1, "a segment that was not begun has no state"

    def test_trace_is_on_the_grid(self, model: TransitionModel, cases: TransitionCases) -> None:
        step = 0.05
        options = RolloutOptions(trace_step=step)
        result = model.rollout(cases.problem.initial, cases.push, options=options)
        trace = result.trace
        assert trace is not None, "a trace was asked for"
        count = len(trace.times)
        np.testing.assert_allclose(trace.times, step * np.arange(count), atol=1e-6)
        assert abs(trace.times[-1] - result.duration) <= step + 1e-6
        objects = len(cases.problem.scene.objects)
        assert trace.joints.shape == (count, cases.push.start.size)
        assert trace.openings.shape == (count,)
        assert trace.poses.shape == (count, objects, 7)
        assert_same(result, model.rollout(cases.problem.initial, cases.push))

    def test_continuation(self, model: TransitionModel, cases: TransitionCases) -> None:
        keeping = RolloutOptions(keep=True)
        first = model.rollout(cases.problem.initial, cases.push, options=keeping)
        if "exact_continuation" not in self.capabilities:
            with pytest.raises(ValueError, match="continu"):
                model.rollout(first.final_state, cases.push, continue_from=object())
            return
        assert first.continuation is not None, "exact_continuation is declared"
        whole = model.rollout(cases.problem.initial, merged(cases.push, cases.crash), options=ALL)
        model.rollout(cases.problem.initial, cases.still)
        rest = model.rollout(
            first.final_state, cases.crash, continue_from=first.continuation, options=ALL
        )
        np.testing.assert_array_equal(rest.final_state.object_poses, whole.final_state.object_poses)


def _overrides(cases: TransitionCases) -> ParameterOverrides:
    """The pushed object, far heavier and rougher."""
    scene = cases.problem.scene
    item = scene.objects[scene.index(cases.pushed)]
    return ParameterOverrides(
        {item.name: item.mass * HEAVIER}, {item.name: item.friction * ROUGHER}
    )


def same(a: RolloutResult, b: RolloutResult) -> bool:
    """Whether two results agree bit for bit in all that is not recorded on request."""
    return (
        _same_state(a.final_state, b.final_state)
        and a.violations == b.violations
        and a.moved == b.moved
        and a.contacts == b.contacts
        and (a.stalled, a.duration, a.steps) == (b.stalled, b.duration, b.steps)
    )


def _same_state(a: SceneState, b: SceneState) -> bool:
    return np.array_equal(a.joint_positions, b.joint_positions) and np.array_equal(
        a.object_poses, b.object_poses
    )


def assert_same(expected: RolloutResult, actual: RolloutResult) -> None:
    """Fail, naming the difference, unless two results agree bit for bit."""
    np.testing.assert_array_equal(
        actual.final_state.object_poses, expected.final_state.object_poses, "object poses"
    )
    np.testing.assert_array_equal(
        actual.final_state.joint_positions, expected.final_state.joint_positions, "joints"
    )
    assert actual.violations == expected.violations
    assert actual.contacts == expected.contacts
    assert same(expected, actual), "results differ in moved, stalled, duration or steps"
