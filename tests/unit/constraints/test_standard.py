"""Each constraint fires exactly when it should, and says what, who, when and how much."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mamo_core.constraints.monitor import ConstraintMonitor
from mamo_core.constraints.options import BoundsOptions, SpeedOptions, TiltOptions
from mamo_core.constraints.standard import (
    BoundsConstraint,
    ContactConstraint,
    SpeedConstraint,
    TiltConstraint,
)
from mamo_core.interfaces.constraint import InteractionConstraint
from mamo_core.types.geometry import Box, Cylinder, make_pose
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import NO_CONTACTS, StepObservation, Violation
from mamo_core.types.scene import Fixture, Mobility, Scene, SceneObject, SceneState, Workspace

ROBOT, A, B, WALL, TARGET, FLOOR, BACK = range(7)
MOVABLE_A, MOVABLE_B, _, HELD = range(4)
NAMES = ("robot", "a", "b", "wall", "target", "floor", "back")


def make_problem():
    shape = Cylinder(0.03, 0.2)
    kinds = [Mobility.MOVABLE, Mobility.MOVABLE, Mobility.IMMOVABLE, Mobility.TARGET]
    objects = tuple(
        SceneObject(name, shape, kind, 0.2, 0.5)
        for name, kind in zip(NAMES[1:5], kinds, strict=True)
    )
    poses = np.array([make_pose([0.1 * i, 0.0, 0.1]) for i in range(4)])
    # One object stands at a slant from the beginning.
    poses[1, 3:] = np.cos(0.1), np.sin(0.1), 0.0, 0.0
    boards = tuple(
        Fixture(name, Box(np.array([1.0, 1.0, 0.1])), make_pose([0.0, 0.0, -0.05]))
        for name in NAMES[5:]
    )
    space = Workspace(np.array([-1.0, -1, 0]), np.array([1.0, 1, 1]))
    scene = Scene("gantry", make_pose([0.0, 0, 0]), boards, objects, space)
    return Problem("four", scene, SceneState(np.zeros(4), poses), np.zeros(4), ())


PROBLEM = make_problem()


def observe(
    time=0.5, *, contacts=(), held=-1, positions=None, axes=None, velocities=None, depths=None
):
    start = PROBLEM.initial.object_poses[:, :3]
    pairs = np.array(contacts, dtype=np.int64) if contacts else NO_CONTACTS
    return StepObservation(
        time=time,
        positions=start.copy() if positions is None else positions,
        z_axes=PROBLEM.initial_z_axes.copy() if axes is None else axes,
        velocities=np.zeros((4, 3)) if velocities is None else velocities,
        contacts=pairs,
        depths=np.zeros(len(pairs)) if depths is None else np.array(depths),
        held=held,
    )


def pair(violation):
    return violation.subject, violation.other


ALLOWED = [
    (ROBOT, A),
    (ROBOT, B),
    (A, B),
    (A, FLOOR),
    (A, BACK),
    (TARGET, FLOOR),
    (WALL, FLOOR),
    (WALL, BACK),
]
FORBIDDEN = [
    (ROBOT, WALL),
    (ROBOT, TARGET),
    (ROBOT, FLOOR),
    (ROBOT, BACK),
    (A, WALL),
    (A, TARGET),
    (B, TARGET),
    (WALL, TARGET),
]


@pytest.mark.parametrize("contact", ALLOWED, ids=str)
@pytest.mark.parametrize("held", [-1, HELD])
def test_allowed_contacts(contact, held):
    assert ContactConstraint(PROBLEM).violations(observe(contacts=[contact], held=held)) == []


@pytest.mark.parametrize("contact", FORBIDDEN, ids=str)
def test_forbidden_contacts(contact):
    found = ContactConstraint(PROBLEM).violations(observe(0.7, contacts=[contact]))
    names = [NAMES[number] for number in contact]
    assert found == [Violation("contact", *names, 0.7, 1.0, 0.0)]
    assert str(found[0]) == f"contact: {names[0]} - {names[1]} at 0.700 s (1 > 0)"


@pytest.mark.parametrize("contact", FORBIDDEN, ids=str)
def test_while_the_target_is_held_the_robot_alone_may_touch_it(contact):
    found = ContactConstraint(PROBLEM).violations(observe(contacts=[contact], held=HELD))
    assert bool(found) == (contact != (ROBOT, TARGET))


def test_holding_something_else_does_not_free_the_target():
    step = observe(contacts=[(ROBOT, TARGET)], held=MOVABLE_A)
    assert len(ContactConstraint(PROBLEM).violations(step)) == 1


def test_every_forbidden_pair_once():
    contacts = [(A, B), (A, WALL), (ROBOT, FLOOR), (A, WALL), (A, WALL)]
    found = ContactConstraint(PROBLEM).violations(observe(contacts=contacts))
    assert [pair(v) for v in found] == [("robot", "floor"), ("a", "wall")]


def tilted(index, angle):
    """The axis of one object turned by ``angle`` from where it was at the start."""
    axes = PROBLEM.initial_z_axes.copy()
    z = axes[index]
    across = np.cross(z, [0.0, 1.0, 0.0])
    axes[index] = np.cos(angle) * z + np.sin(angle) * across / np.linalg.norm(across)
    return axes


@pytest.mark.parametrize("index", [MOVABLE_A, MOVABLE_B, 2, HELD])
def test_tilt(index):
    """Relative to the start, also for an object that was not upright then."""
    constraint = TiltConstraint(PROBLEM, TiltOptions())
    limit = np.radians(25.0)
    assert constraint.violations(observe(axes=tilted(index, limit - 1e-6))) == []
    (found,) = constraint.violations(observe(0.3, axes=tilted(index, limit + 1e-3)))
    assert (found.constraint, found.subject, found.other) == ("tilt", NAMES[1 + index], None)
    assert (found.time, found.limit) == (0.3, pytest.approx(limit))
    assert found.value == pytest.approx(limit + 1e-3, abs=1e-9)


def test_tilt_upside_down():
    (found,) = TiltConstraint(PROBLEM, TiltOptions()).violations(
        observe(axes=tilted(MOVABLE_A, np.pi))
    )
    assert found.value == pytest.approx(np.pi)


def test_turning_about_its_own_axis_is_no_tilt():
    constraint = TiltConstraint(PROBLEM, TiltOptions(limit_deg=0.1))
    assert constraint.violations(observe()) == []


def moving(index, velocity):
    velocities = np.zeros((4, 3))
    velocities[index] = velocity
    return observe(0.4, velocities=velocities)


def test_speed_is_the_norm():
    constraint = SpeedConstraint(PROBLEM, SpeedOptions())
    assert constraint.violations(moving(MOVABLE_A, [0.57, 0.57, -0.57])) == []
    (found,) = constraint.violations(moving(MOVABLE_B, [0.6, -0.6, 0.6]))
    expected = pytest.approx(np.sqrt(3 * 0.36))
    assert (found.constraint, found.subject, found.value, found.limit, found.time) == (
        "speed",
        "b",
        expected,
        1.0,
        0.4,
    )


def test_options_set_the_limits():
    slow = SpeedConstraint(PROBLEM, SpeedOptions(limit=0.2))
    assert slow.violations(moving(MOVABLE_A, [0.21, 0, 0]))[0].limit == 0.2
    assert slow.violations(moving(MOVABLE_A, [0.19, 0, 0])) == []
    strict = TiltConstraint(PROBLEM, TiltOptions(limit_deg=5.0))
    assert strict.violations(observe(axes=tilted(MOVABLE_A, 0.1)))
    shallow = BoundsConstraint(PROBLEM, BoundsOptions(drop=0.01))
    assert shallow.violations(sunk(MOVABLE_A, 0.02))[0].limit == 0.01


def sunk(index, depth, held=-1):
    positions = PROBLEM.initial.object_poses[:, :3].copy()
    positions[index, 2] -= depth
    return observe(0.9, positions=positions, held=held)


def test_bounds():
    constraint = BoundsConstraint(PROBLEM, BoundsOptions())
    assert constraint.violations(sunk(MOVABLE_A, 0.049)) == []
    assert constraint.violations(sunk(MOVABLE_A, -1.0)) == []
    (found,) = constraint.violations(sunk(HELD, 0.3))
    assert (found.constraint, found.subject, found.time) == ("bounds", "target", 0.9)
    assert (found.value, found.limit) == (pytest.approx(0.3), 0.05)


def test_a_held_object_may_be_carried_down():
    constraint = BoundsConstraint(PROBLEM, BoundsOptions())
    assert constraint.violations(sunk(HELD, 0.3, held=HELD)) == []
    assert len(constraint.violations(sunk(MOVABLE_A, 0.3, held=HELD))) == 1


def test_several_objects_at_once():
    velocities = np.zeros((4, 3))
    velocities[[MOVABLE_A, HELD], 0] = 2.0, 3.0
    found = SpeedConstraint(PROBLEM, SpeedOptions()).violations(observe(velocities=velocities))
    assert [(v.subject, v.value) for v in found] == [("a", 2.0), ("target", 3.0)]


def all_four():
    return (
        ContactConstraint(PROBLEM),
        TiltConstraint(PROBLEM, TiltOptions()),
        SpeedConstraint(PROBLEM, SpeedOptions()),
        BoundsConstraint(PROBLEM, BoundsOptions()),
    )


def test_nothing_happens_nothing_is_broken():
    monitor = ConstraintMonitor(all_four())
    assert not any(monitor.see(observe(0.01 * k, contacts=[(A, FLOOR)])) for k in range(5))
    assert monitor.violations == []


def test_the_monitor_keeps_the_onset_alone():
    monitor = ConstraintMonitor(all_four())
    contacts = [[], [(A, WALL)], [(A, WALL)], [(A, WALL), (B, WALL)], [], [(A, WALL)]]
    news = [monitor.see(observe(float(t), contacts=c)) for t, c in enumerate(contacts)]
    assert news == [False, True, False, True, False, True]
    assert [(v.time, v.subject) for v in monitor.violations] == [(1, "a"), (3, "b"), (5, "a")]


def test_different_constraints_on_one_object_are_different_violations():
    monitor = ConstraintMonitor(all_four())
    velocities = np.zeros((4, 3))
    velocities[MOVABLE_A] = [2.0, 0, 0]
    step = observe(contacts=[(A, TARGET)], velocities=velocities, axes=tilted(MOVABLE_A, 1.0))
    assert monitor.see(step)
    found = {(v.constraint, v.subject) for v in monitor.violations}
    assert found == {("contact", "a"), ("tilt", "a"), ("speed", "a")}


STEPS = st.lists(
    st.tuples(
        st.lists(st.sampled_from(ALLOWED + FORBIDDEN), max_size=3),
        st.floats(0.0, 2.0),
        st.floats(0.0, 0.6),
        st.floats(0.0, 0.1),
    ),
    min_size=1,
    max_size=12,
)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(STEPS)
def test_violations_come_in_order_and_start_something(steps):
    """Each is in time order, new at its time, and really beyond its limit."""
    monitor = ConstraintMonitor(all_four())
    broken = []
    for k, (contacts, speed, angle, depth) in enumerate(steps):
        step = observe(
            float(k),
            contacts=contacts,
            velocities=np.array([[speed, 0, 0], [0] * 3, [0] * 3, [0] * 3]),
            axes=tilted(MOVABLE_B, angle),
            positions=sunk(MOVABLE_A, depth).positions,
        )
        before = len(monitor.violations)
        assert monitor.see(step) == (len(monitor.violations) > before)
        broken.append(
            {("contact", NAMES[a], NAMES[b]) for a, b in contacts if (a, b) in FORBIDDEN}
            | ({("speed", "a", None)} if speed > 1.0 else set())
            | ({("tilt", "b", None)} if angle > np.radians(25.0) else set())
            | ({("bounds", "a", None)} if depth > 0.05 else set())
        )
    times = [v.time for v in monitor.violations]
    assert times == sorted(times)
    assert all(v.value > v.limit for v in monitor.violations)
    expected = [now - before for before, now in zip([set(), *broken[:-1]], broken, strict=True)]
    for k, fresh in enumerate(expected):
        found = {(v.constraint, v.subject, v.other) for v in monitor.violations if v.time == k}
        assert found == fresh


class Unlimited(InteractionConstraint):
    """One of somebody else, who knows nothing of limits: it is asked about every step."""

    def __init__(self, constraint):
        self.constraint, self.times = constraint, []

    def violations(self, step):
        self.times.append(step.time)
        return self.constraint.violations(step)


def any_step(time, rng):
    """All may be beyond their limits, some just so, and anything may be in hand."""
    start = PROBLEM.initial.object_poses[:, :3]
    touching = [(ALLOWED + FORBIDDEN)[i] for i in rng.integers(len(ALLOWED + FORBIDDEN), size=2)]
    return observe(
        time,
        contacts=touching[: rng.integers(3)],
        held=int(rng.integers(-1, 4)),
        positions=start - [0.0, 0.0, 1.0] * rng.choice([0.0, 0.049, 0.051, 0.3], size=(4, 1)),
        axes=tilted(int(rng.integers(4)), rng.choice([0.0, 0.436, 0.437])),
        velocities=rng.choice([0.0, 0.57, 0.58], size=(4, 3)),
    )


@settings(max_examples=60)
@given(st.integers(0, 10**6))
def test_what_is_within_the_limits_breaks_nothing(seed):
    """Asked only beyond the limits, or about every step, constraints say the same."""
    rng = np.random.default_rng(seed)
    steps = [any_step(float(k), rng) for k in range(8)]
    for some in (all_four(), all_four()[1:2], all_four()[::-1]):
        quick = ConstraintMonitor(some)
        thorough = ConstraintMonitor([Unlimited(c) for c in some])
        mixed = ConstraintMonitor([some[0], *(Unlimited(c) for c in some[1:])])
        for step in steps:
            assert quick.see(step) == thorough.see(step) == mixed.see(step)
        assert quick.violations == thorough.violations == mixed.violations


def test_constraints_without_limits_see_every_step():
    watcher = Unlimited(SpeedConstraint(PROBLEM, SpeedOptions()))
    for constraints in ([watcher], [*all_four(), watcher]):
        watcher.times.clear()
        monitor = ConstraintMonitor(constraints)
        for k in range(4):
            monitor.see(observe(float(k), contacts=[(A, WALL)] if k == 2 else ()))
        assert watcher.times == [0.0, 1.0, 2.0, 3.0]


def test_the_tightest_of_two_limits_counts():
    constraints = [SpeedConstraint(PROBLEM, SpeedOptions(limit=limit)) for limit in (0.8, 0.3)]
    monitor = ConstraintMonitor(constraints)
    assert monitor.see(moving(MOVABLE_A, [0.5, 0, 0]))
    assert [v.limit for v in monitor.violations] == [0.3]
    assert not ConstraintMonitor(constraints).see(moving(MOVABLE_A, [0.2, 0, 0]))


def test_without_constraints_nothing_is_broken():
    assert not ConstraintMonitor([]).see(observe(contacts=[(A, WALL)]))
