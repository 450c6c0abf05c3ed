"""What a result says is what happened."""

from __future__ import annotations

import numpy as np

from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.testing.conformance.bench import Bench, require
from mamo_core.testing.conformance.repeatability import new_model, require_same
from mamo_core.testing.conformance.scenery import ALL
from mamo_core.testing.transition_cases import shift_along
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import displacements

JOINT_TOLERANCE = 0.05
"""How far the arm may lag behind at the end, rad (or m)."""

REST_TOLERANCE = 0.001
"""Objects that nobody touches stay within this, m."""

MOVED = 0.01
LONGEST_PUSH = 0.15


def still(bench: Bench) -> None:
    cases = bench.cases
    start = cases.problem.initial
    result = new_model(bench).rollout(start, cases.still)
    shifts = displacements(start, result.final_state)
    require(shifts.max() < REST_TOLERANCE, f"objects moved by {shifts.tolist()} m")
    require(result.moved == (), f"reported as moved: {result.moved}")
    _require_valid(result)


def final_state(bench: Bench) -> None:
    cases = bench.cases
    start = cases.problem.initial
    final = new_model(bench).rollout(start, cases.push).final_state
    require(final.object_poses.shape == start.object_poses.shape, "poses are missing")
    require(final.joint_positions.shape == start.joint_positions.shape, "joints are missing")
    norms = np.linalg.norm(final.object_poses[:, 3:], axis=1)
    require(np.abs(norms - 1.0).max() < 1e-6, f"quaternions have lengths {norms.tolist()}")


def arrival(bench: Bench) -> str:
    cases = bench.cases
    result = new_model(bench).rollout(cases.problem.initial, cases.push)
    require(not result.stalled, "the arm stalled")
    lag = float(np.abs(result.final_state.joint_positions - cases.push.end).max())
    require(lag < JOINT_TOLERANCE, f"the arm ends {lag:.3f} rad (or m) from the motion's end")
    return f"{lag:.4f} m"


def push(bench: Bench) -> str:
    cases = bench.cases
    start = cases.problem.initial
    result = new_model(bench).rollout(start, cases.push)
    place = cases.problem.scene.index(cases.pushed)
    poses = start.object_poses[place], result.final_state.object_poses[place]
    shift = shift_along(*poses, np.array(cases.direction))
    require(2 * MOVED < shift < LONGEST_PUSH, f"{cases.pushed} moved by {shift:.3f} m")
    require(("robot", cases.pushed) in result.contacts, "no contact of robot and pushed object")
    _require_valid(result)
    return f"{1e3 * shift:.1f} mm"


def moved(bench: Bench) -> None:
    cases = bench.cases
    start = cases.problem.initial
    result = new_model(bench).rollout(start, cases.push)
    shifts = displacements(start, result.final_state)
    names = [item.name for item in cases.problem.scene.objects]
    expected = [name for name, shift in zip(names, shifts, strict=True) if shift > MOVED]
    require(sorted(result.moved) == sorted(expected), f"{result.moved}, but {expected} moved")
    require(expected == [cases.pushed], f"the push should move {cases.pushed} alone: {expected}")


def contact_pairs(bench: Bench) -> None:
    cases = bench.cases
    scene = cases.problem.scene
    result = new_model(bench).rollout(cases.problem.initial, cases.push)
    places = {name: number for number, name in enumerate(scene.entities)}
    for one, other in result.contacts:
        require(one in places and other in places, f"{one} - {other}: no such names")
        require(places[one] < places[other], f"{one} - {other} is not in the order of the scene")
    among = {pair for pair in result.contacts if places[pair[1]] <= len(scene.objects)}
    expected = {("robot", cases.pushed)}
    require(among == expected, f"robot and objects: {sorted(among)}, expected {sorted(expected)}")


def segment_states(bench: Bench) -> None:
    model, cases = new_model(bench), bench.cases
    start = cases.problem.initial
    result = model.rollout(start, cases.push)
    states = result.segment_states
    require(len(states) == len(cases.push.segments), f"{len(states)} segment states")
    shifts = displacements(start, states[0])
    require(shifts.max() < REST_TOLERANCE, "the first segment does not start at the given state")
    for state, segment in zip(states, cases.push.segments, strict=True):
        lag = float(np.abs(state.joint_positions - segment.trajectory.positions[0]).max())
        require(lag < JOINT_TOLERANCE, f"{segment.kind} starts {lag:.3f} rad off")
    swept = displacements(start, states[1])[cases.problem.scene.index(cases.pushed)]
    require(swept > MOVED, "the second segment does not start after the sweep")
    cut = model.rollout(start, cases.crash)
    require(len(cut.segment_states) == 1, "a segment that was not begun has a state")


def trace(bench: Bench) -> None:
    model, cases, step = new_model(bench), bench.cases, 0.05
    options = RolloutOptions(trace_step=step)
    result = model.rollout(cases.problem.initial, cases.push, options=options)
    recorded = result.trace
    require(recorded is not None, "a trace was asked for")
    assert recorded is not None
    count = len(recorded.times)
    off = np.abs(recorded.times - step * np.arange(count)).max()
    require(off < 1e-6, f"times are {off:.1e} s off the grid")
    gap = abs(recorded.times[-1] - result.duration)
    require(gap <= step + 1e-6, f"the trace ends {gap:.3f} s from the end of the rollout")
    objects = len(cases.problem.scene.objects)
    require(recorded.joints.shape == (count, cases.push.start.size), "joints: wrong shape")
    require(recorded.openings.shape == (count,), "openings: wrong shape")
    require(recorded.poses.shape == (count, objects, 7), "poses: wrong shape")
    require_same(result, model.rollout(cases.problem.initial, cases.push))


def early_stop(bench: Bench) -> None:
    model, cases = new_model(bench), bench.cases
    start = cases.problem.initial
    early = model.rollout(start, cases.crash)
    full = model.rollout(start, cases.crash, options=ALL)
    require(full.violations, "the crash broke no constraint")
    require(early.violations[:1] == full.violations[:1], "the first violation is another one")
    times = {violation.time for violation in early.violations}
    require(len(times) == 1, "violations after the first one")
    require(early.duration <= min(times) + 0.1, "the rollout went on")
    require(not full.stalled, "the crash stalls the arm: the case cannot tell who stopped")
    require(full.duration >= cases.crash.duration - 1e-6, "asked not to stop, but it did")


def time_order(bench: Bench) -> None:
    cases = bench.cases
    result = new_model(bench).rollout(cases.problem.initial, cases.crash, options=ALL)
    times = [violation.time for violation in result.violations]
    require(len(set(times)) > 1, f"expected one violation after the other, got {times}")
    require(times == sorted(times), f"times {times}")
    require(0.0 <= times[0] <= times[-1] <= result.duration + 1e-9, f"times {times}")


def _require_valid(result: RolloutResult) -> None:
    words = [str(violation) for violation in result.violations]
    require(result.valid, f"not valid: stalled {result.stalled}, {words}")
