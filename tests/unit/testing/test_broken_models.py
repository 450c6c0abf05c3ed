"""Each test of the transition-model contract fails for a fake that breaks just that promise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mamo_core.interfaces.transition_model import RolloutOptions, TransitionModel
from mamo_core.testing.gantry import GantryKinematics
from mamo_core.testing.quasi_static import QuasiStaticModel
from mamo_core.testing.transition_cases import (
    TransitionCases,
    gantry_cases,
    standard_constraints,
)
from mamo_core.testing.transition_contract import TransitionModelContract
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import SceneState


def shifted(state: SceneState, by: float) -> SceneState:
    poses = np.array(state.object_poses)
    poses[:, 1] += by
    return SceneState(state.joint_positions, poses)


class Broken(TransitionModel):
    """A sound model whose results go through ``spoil``."""

    def __init__(self, problem: Problem) -> None:
        tool = GantryKinematics().forward
        self.sound = QuasiStaticModel(problem, tool, standard_constraints(problem))

    def rollout(
        self,
        state: SceneState,
        motion: Motion,
        *,
        parameters: ParameterOverrides | None = None,
        options: RolloutOptions | None = None,
        continue_from: Any = None,
    ) -> RolloutResult:
        result = self.sound.rollout(
            state, motion, parameters=parameters, options=options, continue_from=continue_from
        )
        return self.spoil(result, state, motion)

    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        return result


class Random(Broken):
    calls = 0

    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        Random.calls += 1
        return replace(result, final_state=shifted(result.final_state, 1e-12 * Random.calls))


class RemembersCrashes(Broken):
    crashed = False

    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        self.crashed = self.crashed or bool(result.violations)
        return replace(result, duration=result.duration + 1e-9) if self.crashed else result


class CountsModels(Broken):
    made = 0

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        CountsModels.made += 1
        self.number = CountsModels.made

    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        return replace(result, steps=result.steps + self.number)


class WritesIntoItsInput(Broken):
    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        state.object_poses.flags.writeable = True
        state.object_poses[:] = result.final_state.object_poses
        return result


class Drifts(Broken):
    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        return replace(result, final_state=shifted(result.final_state, 0.002))


class LongQuaternions(Broken):
    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        poses = np.array(result.final_state.object_poses)
        poses[:, 3:] *= 1.1
        return replace(result, final_state=SceneState(result.final_state.joint_positions, poses))


class NeverArrives(Broken):
    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        final = result.final_state
        return replace(result, final_state=final.with_joints(final.joint_positions + 0.1))


class PassesThrough(Broken):
    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        joints = result.final_state.joint_positions
        return replace(result, final_state=state.with_joints(joints), moved=())


class ForgetsWhatMoved(Broken):
    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        return replace(result, moved=())


class SeesNoViolation(Broken):
    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        return replace(result, violations=())


class Backwards(Broken):
    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        return replace(result, violations=result.violations[::-1])


class NeverStops(Broken):
    def rollout(self, *args: Any, options: RolloutOptions | None = None, **more: Any) -> Any:
        going_on = replace(options or RolloutOptions(), stop_early=False)
        return super().rollout(*args, options=going_on, **more)


class MixesUpBatches(Broken):
    def rollout_batch(
        self,
        states: Sequence[SceneState],
        motions: Sequence[Motion],
        *,
        parameters: Sequence[ParameterOverrides | None] | None = None,
        options: RolloutOptions | None = None,
    ) -> list[RolloutResult]:
        return super().rollout_batch(states, motions, parameters=parameters, options=options)[::-1]


class IgnoresParameters(Broken):
    def rollout(self, *args: Any, parameters: Any = None, **more: Any) -> Any:
        return super().rollout(*args, **more)


class KeepsParameters(Broken):
    kept: ParameterOverrides | None = None

    def rollout(self, *args: Any, parameters: Any = None, **more: Any) -> Any:
        self.kept = parameters or self.kept
        return super().rollout(*args, parameters=self.kept, **more)


class SegmentEnds(Broken):
    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        return replace(result, segment_states=(*result.segment_states[1:], result.final_state))


class OffGrid(Broken):
    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        trace = result.trace
        return replace(result, trace=trace and replace(trace, times=trace.times + 0.01))


class ContinuesNothing(Broken):
    def spoil(self, result: RolloutResult, state: SceneState, motion: Motion) -> RolloutResult:
        return replace(result, continuation=None)


BROKEN: dict[str, Callable[[Problem], TransitionModel]] = {
    "test_same_arguments_give_the_same_result": Random,
    "test_history_does_not_matter": RemembersCrashes,
    "test_a_new_model_gives_the_same_result": CountsModels,
    "test_arguments_are_left_alone": WritesIntoItsInput,
    "test_nothing_moves_while_the_arm_rests": Drifts,
    "test_final_state_is_complete": LongQuaternions,
    "test_the_arm_arrives": NeverArrives,
    "test_a_push_moves_what_it_meets": PassesThrough,
    "test_moved_names_what_moved": ForgetsWhatMoved,
    "test_a_crash_is_a_contact_violation": SeesNoViolation,
    "test_violations_come_in_time_order": Backwards,
    "test_early_stop_ends_at_the_first_violation": NeverStops,
    "test_a_batch_is_a_loop": MixesUpBatches,
    "test_overrides_change_the_outcome": IgnoresParameters,
    "test_overrides_leave_nothing_behind": KeepsParameters,
    "test_segment_states_are_the_starts_of_segments": SegmentEnds,
    "test_trace_is_on_the_grid": OffGrid,
    "test_continuation": ContinuesNothing,
}


class Contract(TransitionModelContract):
    __test__ = False
    capabilities = frozenset({"exact_continuation"})

    def make_cases(self) -> TransitionCases:
        return gantry_cases()


def contract_of(make: Callable[[Problem], TransitionModel]) -> TransitionModelContract:
    contract = Contract()
    contract.make_model = make  # type: ignore[method-assign]
    return contract


def test_every_promise_has_its_broken_model() -> None:
    promises = {name for name in dir(TransitionModelContract) if name.startswith("test_")}
    assert promises == set(BROKEN)


@pytest.mark.parametrize("promise", BROKEN)
def test_the_sound_model_keeps_the_promise(promise: str) -> None:
    contract = contract_of(Broken)
    cases = contract.make_cases()
    getattr(contract, promise)(Broken(cases.problem), cases)


@pytest.mark.parametrize("promise", BROKEN)
def test_the_broken_model_is_caught(promise: str) -> None:
    contract = contract_of(BROKEN[promise])
    cases = contract.make_cases()
    model = BROKEN[promise](cases.problem)
    with pytest.raises(AssertionError):
        getattr(contract, promise)(model, cases)


def test_a_model_that_takes_any_continuation_is_caught() -> None:
    class TakesAnything(Broken):
        def rollout(self, *args: Any, continue_from: Any = None, **more: Any) -> Any:
            return super().rollout(*args, **more)

    contract = contract_of(TakesAnything)
    contract.capabilities = frozenset()
    cases = contract.make_cases()
    with pytest.raises(pytest.fail.Exception):
        contract.test_continuation(TakesAnything(cases.problem), cases)
