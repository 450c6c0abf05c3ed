"""A rollout is a function of its arguments, whatever ran before, in this process or another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mamo_core.interfaces.transition_model import RolloutOptions, TransitionModel
from mamo_core.testing.conformance.bench import Bench, fail, require
from mamo_core.testing.conformance.scenery import ALL
from mamo_core.testing.transition_cases import merged, standard_constraints
from mamo_core.types.motion import Motion
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import SceneState

HEAVIER, ROUGHER = 120.0, 3.0
"""Factors of the overridden mass and friction."""


def new_model(bench: Bench) -> TransitionModel:
    """A new model of the scripted cases with the standard constraints."""
    problem = bench.cases.problem
    return bench.make(problem, bench.arm, standard_constraints(problem))


def same_arguments(bench: Bench) -> None:
    model, cases = new_model(bench), bench.cases
    start = cases.problem.initial
    require_same(model.rollout(start, cases.push), model.rollout(start, cases.push))


def order(bench: Bench) -> None:
    model, cases = new_model(bench), bench.cases
    start = cases.problem.initial
    first = model.rollout(start, cases.push)
    model.rollout(start, cases.crash)
    model.rollout(first.final_state, cases.push, options=ALL)
    require_same(first, model.rollout(start, cases.push))


def models(bench: Bench) -> None:
    model, other, cases = new_model(bench), new_model(bench), bench.cases
    start = cases.problem.initial
    model.rollout(start, cases.crash)
    require_same(model.rollout(start, cases.push), other.rollout(start, cases.push))


def processes(bench: Bench) -> None:
    cases = bench.cases
    here = new_model(bench).rollout(cases.problem.initial, cases.push)
    require_same(here, bench.in_new_process(cases.problem, cases.push))


def arguments(bench: Bench) -> None:
    cases = bench.cases
    start = cases.problem.initial
    poses, joints = start.object_poses.copy(), start.joint_positions.copy()
    new_model(bench).rollout(start, cases.push)
    require(np.array_equal(start.object_poses, poses), "the initial poses were changed")
    require(np.array_equal(start.joint_positions, joints), "the initial joints were changed")


def batch(bench: Bench) -> None:
    model, cases = new_model(bench), bench.cases
    start = cases.problem.initial
    motions = [cases.push, cases.still, cases.crash, cases.push]
    overrides = [None, None, None, overridden(bench)]
    results = model.rollout_batch([start] * 4, motions, parameters=overrides)
    require(len(results) == 4, f"a batch of 4 gave {len(results)} results")
    for result, motion, override in zip(results, motions, overrides, strict=True):
        require_same(model.rollout(start, motion, parameters=override), result)


def overrides_act(bench: Bench) -> None:
    model, cases = new_model(bench), bench.cases
    start = cases.problem.initial
    nominal = model.rollout(start, cases.push)
    heavy = model.rollout(start, cases.push, parameters=overridden(bench))
    require(difference(nominal, heavy) is not None, "masses and frictions had no effect at all")


def overrides_end(bench: Bench) -> None:
    model, cases = new_model(bench), bench.cases
    start = cases.problem.initial
    before = model.rollout(start, cases.push)
    model.rollout(start, cases.push, parameters=overridden(bench))
    require_same(before, model.rollout(start, cases.push))


def continuation(bench: Bench) -> None:
    """Stopped in mid-push, there are two ways on; each taken twice, in turns, is the same bit for
    bit, and the same as if there had been no stop; with other masses and frictions, too."""
    overrides = "parameter_overrides" in bench.capabilities
    # Lighter, as a heavy object may stall the arm, which ends a rollout.
    lighter = ParameterOverrides({bench.cases.pushed: 0.1}, {bench.cases.pushed: 0.25})
    for parameters in (None, lighter) if overrides else (None,):
        _continued(bench, parameters)


def _continued(bench: Bench, parameters: ParameterOverrides | None) -> None:
    model, start = new_model(bench), bench.cases.problem.initial
    begun, onward, back = _in_mid_push(bench)
    keep = RolloutOptions(stop_early=False, keep=True)
    first = model.rollout(start, begun, parameters=parameters, options=keep)
    token = first.continuation
    require(token is not None, "exact_continuation is declared, but there is none")
    traced = RolloutOptions(stop_early=False, trace_step=0.05)

    def go_on(branch: Motion) -> RolloutResult:
        (result,) = model.rollout_batch(
            [first.final_state],
            [branch],
            parameters=[parameters],
            options=traced,
            continue_from=[token],
        )
        return result

    for branch in (onward, back):
        whole = model.rollout(start, merged(begun, branch), parameters=parameters, options=ALL)
        rest = model.rollout(
            first.final_state, branch, parameters=parameters, continue_from=token, options=traced
        )
        go_on(back if branch is onward else onward)
        again = go_on(branch)
        for result in (rest, again):
            gap = _gap(result.final_state.object_poses, whole.final_state.object_poses)
            require(gap == 0.0, f"it differs from the whole by up to {gap:.1e}")
        require(rest.trace is not None and again.trace is not None, "a trace was asked for")
        assert rest.trace is not None
        assert again.trace is not None
        gap = _gap(rest.trace.poses, again.trace.poses)
        require(gap == 0.0, f"on its way the second time differs by up to {gap:.1e}")


def _in_mid_push(bench: Bench) -> tuple[Motion, Motion, Motion]:
    """The scripted push without time to settle, the rest of the crash, and the way back."""
    sweep, retract = bench.cases.push.segments
    path = bench.cases.crash.segments[0].trajectory
    done = len(sweep.trajectory.times) - 1
    rest = path.part(done, len(path.times) - 1)
    begun = Motion((replace(sweep, settle=0.0),), bench.cases.push.opening)
    onward = Motion((replace(sweep, trajectory=rest),), sweep.opening)
    return begun, onward, Motion((retract,), sweep.opening)


def foreign_continuation(bench: Bench) -> None:
    model, cases = new_model(bench), bench.cases
    try:
        model.rollout(cases.problem.initial, cases.push, continue_from=object())
    except ValueError as error:
        require("continu" in str(error), f"the error does not name the continuation: {error}")
    else:
        fail("a continuation that is none was taken without a word")


def overridden(bench: Bench) -> ParameterOverrides:
    """The pushed object, far heavier and rougher."""
    scene, name = bench.cases.problem.scene, bench.cases.pushed
    item = scene.objects[scene.index(name)]
    return ParameterOverrides({name: item.mass * HEAVIER}, {name: item.friction * ROUGHER})


def require_same(expected: RolloutResult, actual: RolloutResult) -> None:
    """Fail, naming the difference, unless two results agree bit for bit."""
    found = difference(expected, actual)
    require(found is None, f"results differ in {found}")


def difference(a: RolloutResult, b: RolloutResult) -> str | None:
    """What two results do not agree in, of all that is not recorded on request."""
    if not _same_state(a.final_state, b.final_state):
        gap = _gap(a.final_state.object_poses, b.final_state.object_poses)
        return f"the final state (object poses by up to {gap:.1e})"
    for name in ("violations", "moved", "contacts", "stalled", "duration", "steps"):
        if getattr(a, name) != getattr(b, name):
            return name
    return None


def _same_state(a: SceneState, b: SceneState) -> bool:
    return np.array_equal(a.joint_positions, b.joint_positions) and np.array_equal(
        a.object_poses, b.object_poses
    )


def _gap(a: object, b: object) -> float:
    return float(np.abs(np.asarray(a) - np.asarray(b)).max())
