"""Rollouts are functions of their arguments; objects rest, and held ones follow the hand."""

import hashlib
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from mamo_mujoco.engine import MuJoCoWorld

from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.problems import generate_shelf
from mamo_core.robots.kinematics import tool_transform
from mamo_core.testing.transition_cases import merged
from mamo_core.types.geometry import Box, invert, make_pose, matrix_from_pose, z_axes
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.rollout import ParameterOverrides
from mamo_core.types.scene import Fixture, Mobility, SceneState, displacements

ALL = RolloutOptions(stop_early=False)


def waiting(joints, seconds, opening=0.0, **changes):
    trajectory = Trajectory.still(joints, seconds)
    segment = MotionSegment(SegmentKind.TRANSIT, trajectory, opening, **changes)
    return Motion((segment,), opening)


def same(one, other):
    return (
        np.array_equal(one.final_state.object_poses, other.final_state.object_poses)
        and np.array_equal(one.final_state.joint_positions, other.final_state.joint_positions)
        and one.violations == other.violations
        and one.steps == other.steps
        and one.contacts == other.contacts
    )


@pytest.mark.parametrize(
    "options",
    [{}, {"sleep": False}, {"sleep_at_once": True}, {"sleep_at_once": True, "time_step": 0.008}],
)
def test_nothing_drifts(model_of, options):
    problem = generate_shelf(movables=10, seed=1)
    result = model_of(problem, **options).rollout(
        problem.initial, waiting(problem.home, 5.0), options=ALL
    )
    assert result.duration == pytest.approx(5.0, abs=0.2)
    assert result.valid
    assert displacements(problem.initial, result.final_state).max() < 2e-4
    turned = [
        np.degrees(2 * np.arccos(min(1.0, abs(before[3:] @ after[3:]))))
        for before, after in zip(
            problem.initial.object_poses, result.final_state.object_poses, strict=True
        )
    ]
    assert max(turned) < 0.2


def test_what_is_pushed_off_a_table_sinks(cases, model_of):
    """The table ends behind the can, so that the push ends beyond its edge."""
    scene = cases.problem.scene
    start = cases.problem.initial.object_poses[scene.index("can")]
    table = replace(
        scene.fixtures[0],
        shape=Box(np.array([0.2, 0.8, 0.04])),
        pose=make_pose([start[0] - 0.08, -0.5, 0.75]),
    )
    kept = [i for i, item in enumerate(scene.objects) if item.name in ("can", "target")]
    objects = tuple(scene.objects[i] for i in kept)
    problem = replace(
        cases.problem,
        scene=replace(scene, fixtures=(table,), objects=objects),
        initial=SceneState(cases.problem.home, cases.problem.initial.object_poses[kept]),
    )
    result = model_of(problem).rollout(problem.initial, cases.push, options=ALL)
    assert result.final_state.object_poses[0, 2] < start[2] - 0.1
    (fell,) = [v for v in result.violations if v.constraint == "bounds"]
    assert fell.subject == "can"
    assert fell.value > 0.05
    assert not model_of(problem).rollout(problem.initial, cases.push).valid


HASH = """
import hashlib
from mamo_core.robots import load_arm
from mamo_core.testing.transition_cases import pr2_cases, standard_constraints
from mamo_mujoco.model import MuJoCoModel
from mamo_mujoco.options import MuJoCoOptions

cases = pr2_cases()
problem = cases.problem
arm = load_arm(problem.scene.robot)
model = MuJoCoModel(problem, arm, standard_constraints(problem), MuJoCoOptions())
final = model.rollout(problem.initial, cases.push).final_state
print(hashlib.sha256(final.object_poses.tobytes() + final.joint_positions.tobytes()).hexdigest())
"""


def test_another_process_computes_the_same_bits(cases, model):
    final = model.rollout(cases.problem.initial, cases.push).final_state
    ours = hashlib.sha256(final.object_poses.tobytes() + final.joint_positions.tobytes())
    done = subprocess.run(
        [sys.executable, "-c", HASH], capture_output=True, text=True, env=os.environ, check=True
    )
    assert done.stdout.strip() == ours.hexdigest()


def test_a_batch_with_overrides_is_a_loop(cases, model):
    start = cases.problem.initial
    overrides = [None, ParameterOverrides({"can": 1.5}), ParameterOverrides({}, {"can": 0.9}), None]
    motions = [cases.push, cases.push, cases.crash, cases.still]
    states = [start] * 4
    loop = [
        model.rollout(s, m, parameters=p)
        for s, m, p in zip(states, motions, overrides, strict=True)
    ]
    batch = model.rollout_batch(states, motions, parameters=overrides)
    assert all(same(a, b) for a, b in zip(loop, batch, strict=True))


def test_overrides_leave_nothing_behind(cases, model):
    start = cases.problem.initial
    before = model.rollout(start, cases.push)
    heavy = ParameterOverrides({"can": 2.0, "bystander": 0.1}, {"can": 1.0})
    changed = model.rollout(start, cases.push, parameters=heavy)
    assert not same(before, changed)
    assert same(before, model.rollout(start, cases.push))
    assert same(changed, model.rollout(start, cases.push, parameters=heavy))


def test_going_on_is_the_same_as_not_stopping(cases, model):
    start = cases.problem.initial
    back = Motion(
        tuple(
            replace(s, trajectory=s.trajectory.part(0, len(s.trajectory.times) - 1))
            for s in cases.push.segments
        ),
        0.0,
    )
    whole = model.rollout(start, merged(cases.push, back))
    first = model.rollout(start, cases.push, options=RolloutOptions(keep=True))
    # Something else in between, which must not matter.
    model.rollout(start, cases.crash)
    second = model.rollout(first.final_state, back, continue_from=first.continuation)
    assert np.array_equal(whole.final_state.object_poses, second.final_state.object_poses)
    assert whole.steps == first.steps + second.steps
    again = model.rollout(first.final_state, back, continue_from=first.continuation)
    assert same(second, again)


def varied(number):
    """Some masses and frictions, as a robust search draws them."""
    return ParameterOverrides({"can": 0.2 + 0.1 * number}, {"can": 0.3 + 0.04 * number})


def test_kept_worlds_change_nothing(cases, model_of):
    """Each set in turn, several times over, more sets than are kept."""
    start = cases.problem.initial
    sets = [None, *(varied(number) for number in range(18))]
    kept = model_of(cases.problem)
    fresh = [model_of(cases.problem).rollout(start, cases.push, parameters=p) for p in sets[:4]]
    for _ in range(2):
        kept.rollout(start, cases.crash, parameters=sets[1], options=ALL)
        again = [kept.rollout(start, cases.push, parameters=p) for p in sets]
        assert all(same(a, b) for a, b in zip(fresh, again[:4], strict=True))


def test_going_on_in_a_kept_world(cases, model_of):
    """With the same masses and frictions, after others and in another world than before."""
    start, keep = cases.problem.initial, RolloutOptions(keep=True)
    sets = [None, varied(0), varied(1)]
    model = model_of(cases.problem)
    firsts = [model.rollout(start, cases.push, parameters=p, options=keep) for p in sets]
    for parameters, first in zip(sets, firsts, strict=True):
        back = waiting(cases.push.end, 0.3, cases.push.segments[-1].opening)
        whole = model_of(cases.problem).rollout(
            start, merged(cases.push, back), parameters=parameters
        )
        for _ in range(2):
            model.rollout(start, cases.crash, parameters=parameters, options=ALL)
            rest = model.rollout_batch(
                [first.final_state] * 2,
                [back] * 2,
                parameters=[parameters] * 2,
                continue_from=[first.continuation] * 2,
            )
            for result in rest:
                expected, found = whole.final_state, result.final_state
                assert np.array_equal(expected.object_poses, found.object_poses)
                assert np.array_equal(expected.joint_positions, found.joint_positions)
                assert whole.steps == first.steps + result.steps


KERNELS = """
from mamo_core.constraints import kernels as ours
from mamo_core.robots import load_arm
from mamo_core.testing.transition_cases import pr2_cases, standard_constraints
from mamo_mujoco import kernels as theirs
from mamo_mujoco import loop
from mamo_mujoco.model import MuJoCoModel
from mamo_mujoco.options import MuJoCoOptions

def compiled():
    found = [*vars(ours).values(), *vars(theirs).values(), loop.follow, loop.wait]
    return {k.__name__: list(k.signatures) for k in found if hasattr(k, "signatures")}

ours.warm_up()
theirs.warm_up()
loop.warm_up()
before = compiled()
assert len(before) == 8 and all(before.values()), before
cases = pr2_cases()
problem = cases.problem
arm = load_arm(problem.scene.robot)
model = MuJoCoModel(problem, arm, standard_constraints(problem), MuJoCoOptions())
for motion in (cases.push, cases.crash, cases.still):
    model.rollout(problem.initial, motion)
assert compiled() == before, (before, compiled())
"""


def test_no_rollout_waits_for_a_compiler():
    done = subprocess.run(
        [sys.executable, "-c", KERNELS], capture_output=True, text=True, env=os.environ, check=False
    )
    assert done.returncode == 0, done.stderr


def test_foreign_continuations_are_refused(cases, model):
    with pytest.raises(ValueError, match="continue_from: object, expected"):
        model.rollout(cases.problem.initial, cases.still, continue_from=object())


@pytest.mark.parametrize(
    "options", [{"sleep": False}, {"sleep_at_once": True}, {"tolerance": 1e-4}]
)
def test_what_saves_time_changes_little(cases, model, model_of, options):
    start = cases.problem.initial
    results = [m.rollout(start, cases.push) for m in (model, model_of(cases.problem, **options))]
    poses = [r.final_state.object_poses for r in results]
    assert all(r.valid for r in results)
    assert results[0].moved == results[1].moved == ("can",)
    assert np.linalg.norm(poses[0][:, :3] - poses[1][:, :3], axis=1).max() < 3e-3


@pytest.mark.parametrize("meets", [True, False])
def test_arm_and_fixtures_may_be_let_through_each_other(cases, model, model_of, meets):
    problem = cases.problem
    where = model.tool_pose(problem.initial)
    post = Fixture("block", Box(np.array([0.1, 0.1, 0.1])), make_pose(where[:3]))
    scene = replace(problem.scene, fixtures=(*problem.scene.fixtures, post))
    result = model_of(replace(problem, scene=scene), arm_meets_fixtures=meets).rollout(
        problem.initial, cases.still
    )
    assert (("block", "robot") in {tuple(sorted(pair)) for pair in result.contacts}) == meets
    assert result.valid != meets
    pushed = model_of(problem, arm_meets_fixtures=meets).rollout(problem.initial, cases.push)
    assert pushed.moved == ("can",)


def test_the_held_target_follows_the_tool(grasping, arm, model_of):
    problem, motion = grasping
    result = model_of(problem).rollout(
        problem.initial, motion, options=RolloutOptions(trace_step=0.05)
    )
    assert result.valid
    index = problem.scene.target_index
    trace = result.trace
    T_base = matrix_from_pose(problem.scene.T_world_base)

    def relative(row):
        T = T_base @ tool_transform(arm, trace.joints[row])
        return invert(T) @ matrix_from_pose(trace.poses[row, index])

    first = relative(0)
    for row in range(len(trace.times)):
        now = relative(row)
        assert np.linalg.norm(now[:3, 3] - first[:3, 3]) < 4e-3
        assert np.linalg.norm(now[:3, :3] - first[:3, :3]) < 0.05
    rise = result.final_state.object_poses[index, 2] - problem.initial.object_poses[index, 2]
    assert rise == pytest.approx(0.07, abs=4e-3)
    assert z_axes(result.final_state.object_poses)[index, 2] > 0.999


def test_what_is_let_go_falls(grasping, model_of):
    problem, motion = grasping
    lift = motion.segments[0]
    end = lift.trajectory.positions[-1]
    stay = waiting(end, 0.4, lift.opening).segments
    result = model_of(problem).rollout(
        problem.initial, Motion((lift, *stay), lift.opening), options=ALL
    )
    index = problem.scene.target_index
    drop = result.final_state.object_poses[index, 2] - problem.initial.object_poses[index, 2]
    assert drop < 0.03


def test_holding_twice_is_repeatable(grasping, model_of):
    """The weld of one rollout does not show in the next."""
    problem, motion = grasping
    model = model_of(problem)
    first = model.rollout(problem.initial, motion)
    shifted = np.array(problem.initial.object_poses)
    shifted[problem.scene.target_index, 1] += 0.004
    other = model.rollout(SceneState(problem.initial.joint_positions, shifted), motion)
    assert not same(first, other)
    assert same(first, model.rollout(problem.initial, motion))


def test_going_on_while_holding(grasping, model_of):
    problem, motion = grasping
    model = model_of(problem)
    lift, carry = motion.segments
    whole = model.rollout(problem.initial, motion)
    first = model.rollout(
        problem.initial, Motion((lift,), lift.opening), options=RolloutOptions(keep=True)
    )
    second = model.rollout(
        first.final_state, Motion((carry,), lift.opening), continue_from=first.continuation
    )
    assert np.array_equal(whole.final_state.object_poses, second.final_state.object_poses)


def test_letting_go_after_going_on(grasping, model_of):
    problem, motion = grasping
    model = model_of(problem)
    lift = motion.segments[0]
    first = model.rollout(
        problem.initial, Motion((lift,), lift.opening), options=RolloutOptions(keep=True)
    )
    stay = waiting(lift.trajectory.positions[-1], 0.4, lift.opening)
    second = model.rollout(first.final_state, stay, options=ALL, continue_from=first.continuation)
    index = problem.scene.target_index
    drop = second.final_state.object_poses[index, 2] - problem.initial.object_poses[index, 2]
    assert drop < 0.03


def test_an_arm_that_is_blocked_stalls(cases, model_of):
    """By a can of half a ton that may be touched."""
    scene = cases.problem.scene
    objects = tuple(
        replace(o, mass=500.0, friction=1.5) if o.name == "can" else o for o in scene.objects
    )
    problem = replace(cases.problem, scene=replace(scene, objects=objects))
    weak = model_of(problem)
    result = weak.rollout(problem.initial, cases.push)
    assert result.stalled
    assert not result.valid
    assert result.violations == ()
    assert ("robot", "can") in result.contacts
    assert displacements(problem.initial, result.final_state).max() < 5e-3
    # The same arm is strong enough for the can as it is.
    light = model_of(cases.problem).rollout(cases.problem.initial, cases.push)
    assert not light.stalled


def test_servos_keep_to_the_efforts(cases, model_of, arm, monkeypatch):
    """Where the arm pushes half a ton, and on its way there."""
    seen = []
    step = MuJoCoWorld.step

    def watched(world):
        step(world)
        seen.append(np.abs(world.efforts()) / arm.effort)

    monkeypatch.setattr(MuJoCoWorld, "step", watched)
    scene = cases.problem.scene
    objects = tuple(replace(o, mass=500.0, friction=1.5) for o in scene.objects)
    problem = replace(cases.problem, scene=replace(scene, objects=objects))
    model_of(problem).rollout(
        problem.initial, cases.push, options=RolloutOptions(stop_early=False, trace_step=0.1)
    )
    assert 0.9 < np.max(seen) <= 1.0 + 1e-9


def test_immovables_never_move(cases, model):
    result = model.rollout(cases.problem.initial, cases.crash, options=ALL)
    assert any(v.constraint == "contact" for v in result.violations)
    for i, item in enumerate(cases.problem.scene.objects):
        if item.mobility is Mobility.IMMOVABLE:
            before, after = (s.object_poses[i] for s in (cases.problem.initial, result.final_state))
            assert np.array_equal(before, after)


def test_settling_ends_when_everything_rests(cases, model):
    """At most the time that the segment allows, and no longer than needed."""
    joints = cases.problem.home
    times = [
        model.rollout(cases.problem.initial, waiting(joints, 0.1, settle=s)).duration
        for s in (0.0, 0.4, 4.0)
    ]
    assert times[0] < 0.2
    assert times[0] <= times[1] <= times[0] + 0.4 + 1e-9
    assert times[2] < 1.0


def test_a_tumbling_object_is_seen(cases, model):
    """Dropped from above onto the floor: fast, then at rest."""
    poses = np.array(cases.problem.initial.object_poses)
    poses[0] = make_pose([0.66, -0.45, 1.4])
    state = SceneState(cases.problem.home, poses)
    result = model.rollout(state, waiting(cases.problem.home, 0.6), options=ALL)
    assert [v.constraint for v in result.violations if v.subject == "can"][:1] == ["speed"]
    assert "can" in result.moved
