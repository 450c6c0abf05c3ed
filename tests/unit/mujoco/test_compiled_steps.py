"""Steps in one compiled stretch and one by one: nothing that is reported differs by a bit."""

from dataclasses import fields, replace

import numpy as np
import pytest
from mamo_mujoco import memory
from mamo_mujoco.engine import MuJoCoWorld
from mamo_mujoco.model import MuJoCoModel
from mamo_mujoco.options import MuJoCoOptions

from mamo_core.errors import PluginError
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.interfaces.simulated_world import SimulatedWorld
from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.testing.transition_cases import standard_constraints
from mamo_core.types.geometry import make_pose
from mamo_core.types.motion import Motion, MotionSegment, SegmentKind, Trajectory
from mamo_core.types.rollout import ParameterOverrides
from mamo_core.types.scene import SceneState

TO_THE_END = RolloutOptions(stop_early=False, keep=True)
EARLY = RolloutOptions(keep=True)


def bits(value):
    """Something that is equal only for what is equal in every bit."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, (list, tuple)):
        return tuple(bits(part) for part in value)
    if isinstance(value, SceneState):
        return bits([value.joint_positions, value.object_poses])
    return value


def reported(result):
    said = {f.name: bits(getattr(result, f.name)) for f in fields(result)}
    token = said.pop("continuation")
    return said, bits(token.snapshot), token.opening, token.held


@pytest.fixture
def one_by_one(monkeypatch):
    """``one_by_one(run)``: what ``run()`` gives while the engine has no loop of its own."""

    def result_of(run):
        with monkeypatch.context() as patch:
            for name in ("follow", "wait"):
                patch.setattr(MuJoCoWorld, name, getattr(SimulatedWorld, name))
            return run()

    return result_of


@pytest.fixture
def stretches(monkeypatch):
    """How many steps each call of the compiled loops made."""
    made = {"follow": [], "wait": []}

    def counted(name):
        run = getattr(MuJoCoWorld, name)

        def count(self, *arguments):
            made[name].append(run(self, *arguments))
            return made[name][-1]

        return count

    for name in made:
        monkeypatch.setattr(MuJoCoWorld, name, counted(name))
    return made


def both(one_by_one, run):
    """The result of a rollout, after comparing the two ways to it."""
    fast, slow = run(), one_by_one(run)
    assert reported(fast) == reported(slow)
    return fast


def test_a_push_is_one_stretch_a_segment(cases, model, one_by_one, stretches):
    start = cases.problem.initial
    result = both(one_by_one, lambda: model.rollout(start, cases.push, options=EARLY))
    assert ("robot", "can") in result.contacts
    assert len(stretches["follow"]) == len(cases.push.segments)
    assert sum(stretches["follow"]) > 0.9 * result.steps


def test_the_first_violation_ends_a_rollout(cases, model, one_by_one, stretches):
    start = cases.problem.initial
    result = both(one_by_one, lambda: model.rollout(start, cases.crash, options=EARLY))
    assert len(result.violations) == 1
    assert max(stretches["follow"]) > 10


def test_violations_come_and_go(cases, model, one_by_one):
    """What is broken again counts again, with steps in between that nobody looks at."""
    start = cases.problem.initial
    result = both(one_by_one, lambda: model.rollout(start, cases.crash, options=TO_THE_END))
    found = [(v.constraint, v.subject, v.other) for v in result.violations]
    assert len(found) > len(set(found)) > 1


def test_what_is_fast_or_tilted(cases, model, one_by_one):
    """A can that is dropped, and tumbles."""
    start = cases.problem.initial
    poses = np.array(start.object_poses)
    poses[cases.problem.scene.index("can")] = make_pose([0.66, -0.45, 1.4])
    dropped = SceneState(start.joint_positions, poses)
    result = both(one_by_one, lambda: model.rollout(dropped, cases.still, options=TO_THE_END))
    assert {v.constraint for v in result.violations} >= {"speed"}


def test_an_arm_that_stalls(cases, model_of, one_by_one, stretches):
    scene = cases.problem.scene
    objects = tuple(
        replace(o, mass=500.0, friction=1.5) if o.name == "can" else o for o in scene.objects
    )
    problem = replace(cases.problem, scene=replace(scene, objects=objects))
    weak = model_of(problem)
    result = both(one_by_one, lambda: weak.rollout(problem.initial, cases.push, options=EARLY))
    assert result.stalled
    assert stretches["follow"][-1] == 1 < stretches["follow"][0]


@pytest.mark.parametrize("seconds", [0.01, 0.3, 2.0])
def test_settling(cases, model, one_by_one, stretches, seconds):
    """From a drop: it ends before all rests, or after."""
    start = cases.problem.initial
    poses = np.array(start.object_poses)
    poses[cases.problem.scene.index("can"), 2] += 0.02
    dropped = SceneState(start.joint_positions, poses)
    home = start.joint_positions
    brief = Trajectory.still(home, 0.02)
    patient = Motion((MotionSegment(SegmentKind.TRANSIT, brief, 0.0, settle=seconds),), 0.0)
    result = both(one_by_one, lambda: model.rollout(dropped, patient, options=TO_THE_END))
    waited = sum(stretches["wait"])
    assert waited > 0
    assert waited <= result.steps
    if seconds > 0.01:
        assert max(stretches["wait"]) > 10


def test_held_objects(grasping, model_of, one_by_one, stretches):
    """Lifted, carried, let go and left alone: in hand other contacts are allowed."""
    problem, motion = grasping
    end = motion.segments[0].trajectory.positions[-1]
    still = Trajectory.still(end, 0.3)
    left = MotionSegment(SegmentKind.TRANSIT, still, motion.opening, settle=0.2)
    dropping = Motion((motion.segments[0], left), motion.opening)
    model = model_of(problem)
    carried = both(one_by_one, lambda: model.rollout(problem.initial, motion, options=EARLY))
    assert carried.valid
    assert max(stretches["follow"]) > 10
    both(one_by_one, lambda: model.rollout(problem.initial, dropping, options=TO_THE_END))


def test_going_on(cases, model, one_by_one):
    """From where one way ended, the other goes on."""
    start = cases.problem.initial
    masses = ParameterOverrides({"can": 0.5}, {"can": 0.4})

    def first():
        return model.rollout(start, cases.push, parameters=masses, options=EARLY)

    tokens = first().continuation, one_by_one(first).continuation
    results = [
        both(
            one_by_one,
            lambda token=token: model.rollout(
                start, cases.still, parameters=masses, options=EARLY, continue_from=token
            ),
        )
        for token in tokens
    ]
    assert reported(results[0]) == reported(results[1])


def test_threads_change_nothing(cases, model, model_of, one_by_one):
    start = cases.problem.initial
    sets = [ParameterOverrides({"can": 0.2 + 0.1 * number}) for number in range(4)]
    batch = [start] * 4, [cases.push, cases.crash] * 2
    results = [
        m.rollout_batch(*batch, parameters=sets, options=EARLY)
        for m in (model, model_of(cases.problem, batch_threads=2))
    ]
    slow = one_by_one(lambda: model.rollout_batch(*batch, parameters=sets, options=EARLY))
    for one, other, third in zip(*results, slow, strict=True):
        assert reported(one) == reported(other) == reported(third)


class Curious(InteractionConstraint):
    """Wants to see every step."""

    name = "curious"

    def __init__(self):
        self.times = []

    def violations(self, step):
        self.times.append(step.time)
        return []


def test_who_has_no_limits_is_shown_every_step(cases, arm):
    problem, curious = cases.problem, Curious()
    constraints = (*standard_constraints(problem), curious)
    model = MuJoCoModel(problem, arm, constraints, MuJoCoOptions())
    result = model.rollout(problem.initial, cases.push)
    assert len(curious.times) == result.steps
    assert curious.times[-1] == pytest.approx(result.duration)


def test_a_recording_shows_the_same_motion(cases, model, stretches):
    plain = model.rollout(cases.problem.initial, cases.crash, options=TO_THE_END)
    assert max(stretches["follow"]) > 1
    stretches["follow"].clear()
    options = replace(TO_THE_END, trace_step=0.004)
    traced = model.rollout(cases.problem.initial, cases.crash, options=options)
    assert set(stretches["follow"]) == {1}
    assert reported(replace(traced, trace=None)) == reported(plain)


@pytest.fixture
def other_version(monkeypatch):
    """``other_version(name, ctype)``: what the engine says differs in a type (None: unknown)."""

    def change(name, ctype):
        known = {key: value for key, value in memory._PLAIN.items() if key != name}
        monkeypatch.setattr(memory, "_PLAIN", known | ({name: ctype} if ctype else {}))
        forget()

    def forget():
        memory._check.cache_clear()
        memory._structure.cache_clear()

    yield change
    monkeypatch.undo()
    forget()


@pytest.mark.parametrize("name", ["mjtSize", "mjtBool", "int", "mjtNum"])
def test_another_layout_is_refused(cases, model_of, other_version, name):
    other_version(name, memory.ctypes.c_uint16)
    with pytest.raises(PluginError, match="does not have its contacts where its own description"):
        model_of(cases.problem)


def test_an_unknown_type_is_refused(cases, model_of, other_version):
    other_version("mjtNum", None)
    with pytest.raises(PluginError, match="a type that mamo does not know: mjtNum; install the"):
        model_of(cases.problem)
