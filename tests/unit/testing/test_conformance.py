"""Each check of the conformance suite fails for a model that breaks just that promise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mamo_core.hookspecs import Component
from mamo_core.interfaces.transition_model import RolloutOptions, TransitionModel
from mamo_core.plugins import discover
from mamo_core.testing.conformance.bench import Bench, CheckFailedError, fail
from mamo_core.testing.conformance.fake_bench import quasi_static_bench
from mamo_core.testing.conformance.runner import Verdict, bench_of, run_check, summary
from mamo_core.testing.conformance.table import CHECKS, Check
from mamo_core.types.geometry import Array
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides, RolloutResult, Violation
from mamo_core.types.scene import SceneState


class Spoiled(TransitionModel):
    """A sound model; subclasses break one thing."""

    def __init__(self, sound: TransitionModel, problem: Problem) -> None:
        self.sound, self.problem = sound, problem

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
        return self.spoil(result, state)

    def tool_pose(self, state: SceneState) -> Array:
        return self.sound.tool_pose(state)

    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        return result


def shifted(result: RolloutResult, by: float) -> RolloutResult:
    poses = np.array(result.final_state.object_poses)
    poses[:, 1] += by
    return replace(result, final_state=SceneState(result.final_state.joint_positions, poses))


def with_violations(
    result: RolloutResult, change: Callable[[Violation], Violation | None]
) -> RolloutResult:
    changed = [change(violation) for violation in result.violations]
    return replace(result, violations=tuple(v for v in changed if v is not None))


class Counts(Spoiled):
    calls = 0

    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        self.calls += 1
        return shifted(result, 1e-12 * self.calls)


class RemembersCrashes(Spoiled):
    crashed = False

    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        self.crashed = self.crashed or bool(result.violations)
        return replace(result, duration=result.duration + 1e-9) if self.crashed else result


class CountsModels(Spoiled):
    made = 0

    def __init__(self, sound: TransitionModel, problem: Problem) -> None:
        super().__init__(sound, problem)
        CountsModels.made += 1
        self.number = CountsModels.made

    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        return replace(result, steps=result.steps + self.number)


class WritesIntoItsInput(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        state.object_poses.flags.writeable = True
        state.object_poses[:] = result.final_state.object_poses
        return result


class MixesUpBatches(Spoiled):
    def rollout_batch(
        self,
        states: Sequence[SceneState],
        motions: Sequence[Motion],
        *,
        parameters: Sequence[ParameterOverrides | None] | None = None,
        options: RolloutOptions | None = None,
    ) -> list[RolloutResult]:
        return super().rollout_batch(states, motions, parameters=parameters, options=options)[::-1]


class IgnoresParameters(Spoiled):
    def rollout(self, *args: Any, parameters: Any = None, **more: Any) -> RolloutResult:
        return super().rollout(*args, **more)


class IgnoresMasses(Spoiled):
    def rollout(self, *args: Any, parameters: Any = None, **more: Any) -> RolloutResult:
        left = parameters and ParameterOverrides({}, parameters.frictions)
        return super().rollout(*args, parameters=left, **more)


class IgnoresFrictions(Spoiled):
    def rollout(self, *args: Any, parameters: Any = None, **more: Any) -> RolloutResult:
        left = parameters and ParameterOverrides(parameters.masses, {})
        return super().rollout(*args, parameters=left, **more)


class KeepsParameters(Spoiled):
    kept: ParameterOverrides | None = None

    def rollout(self, *args: Any, parameters: Any = None, **more: Any) -> RolloutResult:
        self.kept = parameters or self.kept
        return super().rollout(*args, parameters=self.kept, **more)


class UsesContinuationsUp(Spoiled):
    uses = 0

    def rollout(self, *args: Any, continue_from: Any = None, **more: Any) -> RolloutResult:
        result = super().rollout(*args, continue_from=continue_from, **more)
        self.uses += continue_from is not None
        return result if self.uses < 3 else shifted(result, 1e-9)


class TakesAnyContinuation(Spoiled):
    def rollout(self, *args: Any, continue_from: Any = None, **more: Any) -> RolloutResult:
        return super().rollout(*args, **more)


class Drifts(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        return shifted(result, 0.003)


class DriftsALittle(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        return shifted(result, 0.0003)


class LongQuaternions(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        poses = np.array(result.final_state.object_poses)
        poses[:, 3:] *= 1.1
        return replace(result, final_state=SceneState(result.final_state.joint_positions, poses))


class NeverArrives(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        final = result.final_state
        return replace(result, final_state=final.with_joints(final.joint_positions + 0.1))


class PassesThrough(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        joints = result.final_state.joint_positions
        return replace(result, final_state=state.with_joints(joints), moved=())


class ForgetsWhatMoved(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        return replace(result, moved=())


class SwapsPairs(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        return replace(result, contacts=frozenset((b, a) for a, b in result.contacts))


class SegmentEnds(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        return replace(result, segment_states=(*result.segment_states[1:], result.final_state))


class OffGrid(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        trace = result.trace
        return replace(result, trace=trace and replace(trace, times=trace.times + 0.01))


class NeverStops(Spoiled):
    def rollout(
        self, *args: Any, options: RolloutOptions | None = None, **more: Any
    ) -> RolloutResult:
        going_on = replace(options or RolloutOptions(), stop_early=False)
        return super().rollout(*args, options=going_on, **more)


class Backwards(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        return replace(result, violations=result.violations[::-1])


class ToolElsewhere(Spoiled):
    def tool_pose(self, state: SceneState) -> Array:
        return super().tool_pose(state) + np.array([1e-5, 0, 0, 0, 0, 0, 0])


class Slippery(Spoiled):
    """Every friction is too low."""

    share = 0.9

    def rollout(self, *args: Any, parameters: Any = None, **more: Any) -> RolloutResult:
        objects = self.problem.scene.objects
        wrong = {item.name: self.share * item.friction for item in objects}
        return super().rollout(*args, parameters=ParameterOverrides({}, wrong), **more)


class Rough(Slippery):
    """As if fixtures did not halve friction."""

    share = 2.0


class Upright(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        poses = np.array(result.final_state.object_poses)
        poses[:, 3:] = state.object_poses[:, 3:]
        return replace(result, final_state=SceneState(result.final_state.joint_positions, poses))


class HoldsNothing(Spoiled):
    def rollout(self, state: SceneState, motion: Motion, **more: Any) -> RolloutResult:
        dropped = tuple(replace(segment, held=None) for segment in motion.segments)
        return super().rollout(state, replace(motion, segments=dropped), **more)


class LeavesImmovables(Spoiled):
    first: SceneState | None = None

    def rollout(self, state: SceneState, motion: Motion, **more: Any) -> RolloutResult:
        self.first = self.first or state
        return super().rollout(self.first, motion, **more)


class Lags(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        trace = result.trace
        return replace(result, trace=trace and replace(trace, joints=trace.joints - 0.03))


class NeverStalls(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        return replace(result, stalled=False)


class Late(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        return with_violations(result, lambda v: replace(v, time=v.time + 0.1))


class TurnsPairsRound(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        return with_violations(
            result, lambda v: replace(v, subject=v.other, other=v.subject) if v.other else v
        )


class HalfTheTilt(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        return with_violations(
            result, lambda v: replace(v, value=v.value / 2) if v.constraint == "tilt" else v
        )


class SeesPhantoms(Spoiled):
    def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
        phantom = Violation("speed", "target", None, 0.0, 2.0, 1.0)
        return replace(result, violations=(*result.violations, phantom))


def blind_to(**what: str) -> type[Spoiled]:
    """A model that does not report violations with these attributes."""

    class Blind(Spoiled):
        def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
            return with_violations(
                result,
                lambda v: None if all(getattr(v, k) == w for k, w in what.items()) else v,
            )

    return Blind


def with_models(model: type[Spoiled]) -> Callable[[Bench], Bench]:
    """The bench, its models spoiled."""

    def spoil(bench: Bench) -> Bench:
        make = lambda problem, *more: model(bench.make(problem, *more), problem)  # noqa: E731
        return replace(bench, make=make)

    return spoil


def another_process_gives_another_result(bench: Bench) -> Bench:
    return replace(bench, in_new_process=lambda *args: shifted(bench.in_new_process(*args), 1e-12))


def stays_in_this_process(bench: Bench) -> Bench:
    return replace(bench, make_default=bench.make)


BROKEN_FAKES = {
    "same_arguments": with_models(Counts),
    "order": with_models(RemembersCrashes),
    "models": with_models(CountsModels),
    "processes": another_process_gives_another_result,
    "arguments": with_models(WritesIntoItsInput),
    "batch": with_models(MixesUpBatches),
    "overrides_act": with_models(IgnoresParameters),
    "overrides_end": with_models(KeepsParameters),
    "continuation": with_models(UsesContinuationsUp),
    "foreign_continuation": with_models(TakesAnyContinuation),
    "still": with_models(Drifts),
    "final_state": with_models(LongQuaternions),
    "arrival": with_models(NeverArrives),
    "push": with_models(PassesThrough),
    "moved": with_models(ForgetsWhatMoved),
    "contact_pairs": with_models(SwapsPairs),
    "segment_states": with_models(SegmentEnds),
    "trace": with_models(OffGrid),
    "early_stop": with_models(NeverStops),
    "time_order": with_models(Backwards),
}
"""Check -> how the quasi-static model is broken."""

BROKEN_ENGINES = {
    "forward_kinematics": with_models(ToolElsewhere),
    "rest": with_models(DriftsALittle),
    "stacks": with_models(Drifts),
    "sliding": with_models(Slippery),
    "tipping": with_models(Upright),
    "incline": with_models(PassesThrough),
    "object_friction": with_models(Slippery),
    "fixture_friction": with_models(Rough),
    "half_friction": with_models(IgnoresFrictions),
    "double_mass": with_models(IgnoresMasses),
    "attachment": with_models(HoldsNothing),
    "tracking": with_models(Lags),
    "stall": with_models(NeverStalls),
    "robot_touches_immovable": with_models(Late),
    "robot_touches_target": with_models(blind_to(constraint="contact", other="target")),
    "robot_touches_itself": with_models(blind_to(constraint="contact", other="robot")),
    "robot_touches_fixture": with_models(blind_to(constraint="contact", other="rail")),
    "object_touches_immovable": with_models(TurnsPairsRound),
    "object_touches_target": with_models(blind_to(constraint="contact", subject="b")),
    "clearance": with_models(blind_to(constraint="contact", other="post")),
    "tilt": with_models(HalfTheTilt),
    "speed": with_models(Late),
    "bounds": with_models(blind_to(constraint="bounds")),
    "penetration": with_models(blind_to(constraint="penetration")),
    "immovables": with_models(LeavesImmovables),
    "nothing_else": with_models(SeesPhantoms),
    "killed": stays_in_this_process,
}
"""Check -> how MuJoCo is broken."""

TABLE = {check.name: check for check in CHECKS}


def test_every_check_has_its_broken_model() -> None:
    assert {*BROKEN_FAKES, *BROKEN_ENGINES} == set(TABLE)
    assert len(TABLE) == len(CHECKS)


@pytest.mark.parametrize("name", BROKEN_FAKES)
def test_a_broken_fake_is_caught(name: str) -> None:
    with pytest.raises(CheckFailedError):
        TABLE[name].run(BROKEN_FAKES[name](quasi_static_bench()))


@pytest.mark.parametrize("name", BROKEN_ENGINES)
def test_a_broken_engine_is_caught(name: str) -> None:
    mujoco = bench_of(discover().component("backend", "mujoco", "test"))
    with pytest.raises(CheckFailedError):
        TABLE[name].run(BROKEN_ENGINES[name](mujoco))


def test_a_model_without_continuations_is_caught() -> None:
    class ContinuesNothing(Spoiled):
        def spoil(self, result: RolloutResult, state: SceneState) -> RolloutResult:
            return replace(result, continuation=None)

    with pytest.raises(CheckFailedError, match="exact_continuation is declared"):
        TABLE["continuation"].run(with_models(ContinuesNothing)(quasi_static_bench()))


def passes(_: Bench) -> str:
    return "0.1 mm"


def fails(_: Bench) -> None:
    fail("2 mm too far")


def is_not_there(_: Bench) -> None:
    raise NotImplementedError("no tool_pose")


def crashes(_: Bench) -> None:
    raise ZeroDivisionError("division by zero")


def engine(**declared: Any) -> Component:
    return Component("toy", lambda *_: None, **declared)


@pytest.mark.parametrize(
    ("run", "needs", "declared", "verdict", "words"),
    [
        (passes, None, {}, Verdict.PASSED, ""),
        (fails, None, {}, Verdict.FAILED, "2 mm too far"),
        (crashes, None, {}, Verdict.FAILED, "ZeroDivisionError: division by zero"),
        (is_not_there, None, {}, Verdict.SKIPPED_UNDECLARED, "no tool_pose"),
        (is_not_there, "exact_continuation", {}, Verdict.SKIPPED_UNDECLARED, "no tool_pose"),
        (passes, "dynamics", {}, Verdict.DECLARED_UNSUPPORTED, "dynamics"),
        (fails, None, {"known_gaps": {"c": "soft"}}, Verdict.KNOWN_GAP, "soft (2 mm too far)"),
        (passes, None, {"known_gaps": {"c": "soft"}}, Verdict.FAILED, "known gap has healed: soft"),
    ],
)
def test_verdicts(
    run: Callable[[Bench], str | None],
    needs: str | None,
    declared: dict[str, Any],
    verdict: Verdict,
    words: str,
) -> None:
    check = Check("c", "a promise", run, needs)
    report = run_check(check, quasi_static_bench(), engine(**declared))
    assert (report.verdict, report.message) == (verdict, words)


def test_a_grade_is_reported() -> None:
    check = Check("c", "a promise", passes)
    report = run_check(check, quasi_static_bench(), engine(grades={"c": "within 1 mm"}))
    assert (report.grade, report.measured) == ("within 1 mm", "0.1 mm")
    assert run_check(check, quasi_static_bench(), engine()).grade == "exact"


def test_summary_counts_every_verdict() -> None:
    bench = quasi_static_bench()
    reports = [
        run_check(Check("a", "", passes), bench, engine()),
        run_check(Check("b", "", fails), bench, engine()),
        run_check(Check("c", "", passes, "dynamics"), bench, engine()),
    ]
    assert summary(reports) == {
        "passed": 1,
        "failed": 1,
        "declared_unsupported": 1,
        "known_gaps": 0,
        "skipped_undeclared": 0,
    }
