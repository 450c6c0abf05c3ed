"""Coulomb friction, rest, tipping: figures that can be computed by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.robots.kinematics import link_transforms
from mamo_core.robots.library import load_arm
from mamo_core.testing.conformance.bench import Bench, require
from mamo_core.testing.conformance.scenery import (
    GRAVITY,
    box,
    heading,
    line,
    motion,
    on_a_board,
    placed,
    still,
    tilt_deg,
    tool,
)
from mamo_core.testing.gantry_arm import FOOT
from mamo_core.types.geometry import (
    Array,
    BoolArray,
    Box,
    Cylinder,
    make_pose,
    matrix_from_pose,
    quat_from_rotation,
)
from mamo_core.types.motion import MotionSegment
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides
from mamo_core.types.scene import Fixture, Mobility, SceneObject, SceneState

FK_TOLERANCE = 1e-6
DRIFT, TURN = 2e-4, 0.2
"""Objects at rest stay within this for 5 s: m, degrees."""

STACK_DRIFT, STACK_TURN = 2e-3, 1.0
FRICTION, SPEED = 0.5, 0.5
SLIDE = 0.06
"""Sliding distances are right within this share."""

_GRID = 0.005
_ON_TOP = 0.3
"""Coefficients measured on a box that shakes a little are right within this share."""

ALL = RolloutOptions(stop_early=False)


def forward_kinematics(bench: Bench) -> str:
    worst = 0.0
    for name in ("pr2_right_arm", "panda"):
        arm = load_arm(name)
        rng = np.random.default_rng(0)
        base = make_pose([0.3, -0.2, 0.4], 0.5)
        problem = _with_robot(name, base, arm.home)
        model = bench.make(problem, arm, ())
        for _ in range(10):
            q = rng.uniform(arm.lower, arm.upper)
            state = problem.initial.with_joints(q)
            T = matrix_from_pose(base) @ link_transforms(arm, q, arm.gripper.closed)[arm.tool_link]
            gap = np.abs(matrix_from_pose(model.tool_pose(state)) - T).max()
            worst = max(worst, float(gap))
    require(worst < FK_TOLERANCE, f"the tool is {worst:.1e} m (or rad) off (most {FK_TOLERANCE})")
    return f"{worst:.1e}"


def _with_robot(name: str, base: Array, home: Array) -> Problem:
    """A target on a board, and the robot beside it."""
    problem = on_a_board()
    scene = replace(problem.scene, robot=name, T_world_base=base)
    initial = SceneState(home, problem.initial.object_poses)
    return replace(problem, scene=scene, initial=initial, home=home)


def rest(bench: Bench) -> str:
    can = SceneObject("can", Cylinder(0.04, 0.18), Mobility.MOVABLE, 0.2, 0.9)
    problem = on_a_board(
        placed(box("tall", (0.07, 0.09, 0.24), 0.1, 1.0), 0.0, 0.0, 0.4),
        placed(box("heavy", (0.12, 0.08, 0.15), 0.5, 0.8), 0.4, 0.0),
        placed(can, 0.0, 0.4),
    )
    result = bench.make(problem, bench.arm, ()).rollout(problem.initial, still(5.0))
    shift, turn = _largest_change(problem, result.final_state)
    require(shift < DRIFT, f"an object drifted by {1e3 * shift:.3f} mm in 5 s (most 0.2)")
    require(turn < TURN, f"an object turned by {turn:.3f} degrees in 5 s (most 0.2)")
    return f"{1e3 * shift:.3f} mm, {turn:.3f} deg"


def stacks(bench: Bench) -> str:
    low, high = box("low", (0.12, 0.12, 0.10)), box("high", (0.08, 0.08, 0.12))
    plank, angle = box("plank", (0.02, 0.10, 0.20), 0.1, 0.9), np.radians(15.0)
    pose_of_high = make_pose([0.0, 0.0, 0.16], 0.3)
    leaning = _leaning(plank, angle)
    wall = Fixture("wall", Box(np.array([0.1, 0.4, 0.4])), make_pose([0.75, 0.0, 0.2]))
    problem = on_a_board(
        placed(low, 0.0, 0.0), (high, pose_of_high), (plank, leaning), fixtures=[wall]
    )
    result = bench.make(problem, bench.arm, ()).rollout(problem.initial, still(1.5))
    shift, turn = _largest_change(problem, result.final_state)
    require(shift < STACK_DRIFT, f"an object moved by {1e3 * shift:.2f} mm (most 2)")
    require(turn < STACK_TURN, f"an object turned by {turn:.2f} degrees (most 1)")
    return f"{1e3 * shift:.2f} mm, {turn:.2f} deg"


def _leaning(plank: SceneObject, angle: float) -> Array:
    """Leaning towards +x with its upper edge at the wall, which begins at x = 0.70."""
    shape = plank.shape
    assert isinstance(shape, Box)
    rotation = np.array(
        [
            [np.cos(angle), 0.0, np.sin(angle)],
            [0.0, 1.0, 0.0],
            [-np.sin(angle), 0.0, np.cos(angle)],
        ]
    )
    half = shape.size / 2.0
    corners = rotation @ np.array([[sx * half[0], 0.0, sz * half[2]] for sx, sz in _SIDES]).T
    position = [0.70 - corners[0].max(), 0.0, -corners[2].min()]
    return np.concatenate([position, quat_from_rotation(rotation)])


_SIDES = ((1, 1), (1, -1), (-1, 1), (-1, -1))


def sliding(bench: Bench) -> str:
    theory = SPEED**2 / (2.0 * FRICTION * GRAVITY)
    distances = slide_distances(bench, (0.0, 22.5, 45.0))
    for degrees, distance in distances.items():
        require(
            abs(distance / theory - 1.0) < SLIDE,
            f"at {degrees:g} degrees a box slid {1e3 * distance:.1f} mm, by theory it is "
            f"{1e3 * theory:.1f} mm (6 % allowed)",
        )
    found = ", ".join(f"{1e3 * d:.1f}" for d in distances.values())
    return f"{found} mm; theory {1e3 * theory:.1f} mm"


def slide_distances(
    bench: Bench, degrees: tuple[float, ...], parameters: ParameterOverrides | None = None
) -> dict[float, float]:
    """How far (m) boxes that a hand pushed to ``SPEED`` slide on by themselves, by heading."""
    side, apart = 0.12, 0.8
    # Close by, and gaining speed slowly: a hit would fling the box away from the hand.
    back = side / 2.0 + FOOT / 2.0 + 0.001
    starts, ends, items = [], [], []
    for k, angle in enumerate(np.radians(degrees)):
        middle = tool(-0.5, apart * (k - 1), 0.015, angle)
        starts.append(middle - back * heading(angle))
        # 0.6 s: a whole number of steps of most engines, so that the last one is not slower.
        ends.append(starts[-1] + 0.225 * heading(angle))
        item = box(f"b{k}", (side, side, 0.04), 0.3, FRICTION)
        items.append(placed(item, middle[0], middle[1], angle))
    segments: list[MotionSegment] = []
    for start, end in zip(starts, ends, strict=True):
        if segments:
            segments += _over(segments[-1].trajectory.positions[-1], start)
        segments += [line(start, end, SPEED, ramp=0.3), _stay(end, 0.3)]
    problem = on_a_board(*items, start=starts[0])
    options = RolloutOptions(stop_early=False, trace_step=_GRID)
    result = bench.make(problem, bench.arm, ()).rollout(
        problem.initial, motion(*segments), parameters=parameters, options=options
    )
    require(not result.stalled, "the arm stalled while it pushed a box")
    trace = result.trace
    require(trace is not None and trace.contacts is not None, "the trace has no contacts")
    assert trace is not None
    assert trace.contacts is not None
    return {
        angle: _free_slide(trace.poses[:, k, :2], trace.contacts[:, 0, 1 + k])
        for k, angle in enumerate(degrees)
    }


def _free_slide(positions: Array, pushed: BoolArray) -> float:
    """The way (m) after the last contact, for a start at ``SPEED``; positions (t, 2) on the grid.

    How fast the box is when the hand falls behind depends on how the arm brakes, so the speed is
    taken from the recorded motion.
    """
    require(pushed.any(), "the hand never touched the box")
    first = int(np.flatnonzero(pushed)[-1]) + 2
    gone = np.linalg.norm(positions[first:] - positions[first], axis=1)
    sliding = gone < 0.9 * gone[-1]
    count = int(np.argmin(sliding))
    require(count >= 5, f"the box slid on for {gone[-1] * 1e3:.1f} mm only, too short to measure")
    fit = np.polyfit(_GRID * np.arange(count), gone[:count], 2)
    return float(gone[-1] * (SPEED / fit[1]) ** 2)


def _over(start: Array, end: Array) -> list[MotionSegment]:
    """Back, up, across and down, so that nothing is touched."""
    back = start - 0.1 * heading(start[3])
    above = tool(0.0, 0.0, 0.2)
    return [
        line(start, back, 0.5),
        line(back, back + above, 1.0),
        line(back + above, end + above, 1.0),
        line(end + above, end, 1.0),
    ]


def _stay(where: Array, seconds: float) -> MotionSegment:
    return still(seconds, where).segments[0]


def tipping(bench: Bench) -> str:
    width, height = 0.08, 0.24
    critical = width / (2.0 * FRICTION)
    tilts = []
    for share, name in ((0.45, "low"), (2.2, "high")):
        item = box(name, (width, 0.10, height), 0.3, FRICTION)
        start = tool(-0.10, 0.0, share * critical - 0.01)
        problem = on_a_board(placed(item, 0.0, 0.0), start=start)
        push = motion(line(start, start + 0.09 * heading(0.0), 0.1))
        result = bench.make(problem, bench.arm, ()).rollout(problem.initial, push, options=ALL)
        pose = result.final_state.object_poses[0]
        tilts.append(tilt_deg(pose))
        if name == "low":
            require(pose[0] > 0.02, f"a box pushed below {critical} m did not slide")
    low, high = tilts
    require(low < 3.0, f"a box pushed at 0.45 of the critical height tilts by {low:.1f} degrees")
    require(high > 8.0, f"a box pushed at 2.2 times that height tilts by {high:.1f} degrees only")
    return f"{low:.1f} deg below, {high:.1f} deg above"


def incline(bench: Bench) -> str:
    return _starts_to_slide(bench, FRICTION, 1.0)


def fixture_friction(bench: Bench) -> str:
    return _starts_to_slide(bench, 0.8, 0.5)


def _starts_to_slide(bench: Bench, of_box: float, of_plane: float) -> str:
    critical = np.arctan(of_box * of_plane)
    fixtures, items = [], []
    for k, share in enumerate((0.9, 1.1)):
        rotation = _about_y(share * critical)
        base = np.array([0.0, 1.0 * k - 0.5, 0.6])
        quat = quat_from_rotation(rotation)
        plane = Box(np.array([1.2, 0.4, 0.04]))
        pose = np.concatenate([base, quat])
        fixtures.append(Fixture(f"plane{k}", plane, pose, of_plane))
        centre = base + rotation @ np.array([-0.3, 0.0, 0.04])
        item = box(f"b{k}", (0.12, 0.12, 0.04), 0.3, of_box)
        items.append((item, np.concatenate([centre, quat])))
    problem = on_a_board(*items, fixtures=fixtures)
    result = bench.make(problem, bench.arm, ()).rollout(problem.initial, still(0.6))
    moved = result.final_state.object_poses[:2, :3] - problem.initial.object_poses[:2, :3]
    below, above = np.linalg.norm(moved, axis=1)
    require(below < 1.5e-3, f"at 0.9 of the critical angle it slid {1e3 * below:.1f} mm")
    require(above > 0.03, f"at 1.1 of the critical angle it slid only {1e3 * above:.1f} mm")
    return f"{1e3 * below:.2f} mm below, {1e3 * above:.0f} mm above"


def object_friction(bench: Bench) -> str:
    """A box on another one that the hand speeds up: friction alone carries it along."""
    of_low, of_high, speed, ramp = 0.4, 0.25, 0.6, 0.4
    start = tool(-0.10 - FOOT / 2.0 - 0.001, 0.0, 0.015)
    low, high = (
        box("low", (0.2, 0.2, 0.04), 0.3, of_low),
        box("high", (0.06, 0.06, 0.04), 0.1, of_high),
    )
    problem = on_a_board(placed(low, 0.0, 0.0), (high, make_pose([0.0, 0.0, 0.06])), start=start)
    push = motion(line(start, start + 0.5 * speed * ramp * heading(0.0), speed, ramp=ramp))
    options = RolloutOptions(stop_early=False, trace_step=_GRID)
    result = bench.make(problem, bench.arm, ()).rollout(problem.initial, push, options=options)
    trace = result.trace
    require(trace is not None, "a trace was asked for")
    assert trace is not None
    last = int(np.searchsorted(trace.times, ramp - 1e-9))
    low_x, high_x = trace.poses[last, :2, 0]
    require(low_x > 0.1, f"the hand pushed the lower box by {1e3 * low_x:.0f} mm only")
    found, product = 2.0 * high_x / (GRAVITY * ramp**2), of_low * of_high
    require(
        abs(found / product - 1.0) < _ON_TOP,
        f"a box on a box is carried along with a coefficient of {found:.3f}, not {product:.3f}",
    )
    return f"{found:.3f}; product {product:.3f}"


def _about_y(angle: float) -> Array:
    """Down towards +x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def attachment(bench: Bench) -> str:
    start = tool(0.0, 0.0, 0.15)
    problem = on_a_board(placed(box("b", (0.06, 0.06, 0.12)), 0.0, 0.0), start=start)
    raised, over = start + tool(0, 0, 0.1), start + tool(0.2, 0.1, 0.1)
    lowered = start + tool(0.2, 0.1, 0.0)
    carry = motion(
        line(start, raised, 0.3, held="b"),
        line(raised, over, 0.3, held="b"),
        line(over, lowered, 0.3, held="b"),
        line(lowered, lowered + tool(0, 0, 0.2), 0.5, settle=0.5),
    )
    result = bench.make(problem, bench.arm, ()).rollout(problem.initial, carry, options=ALL)
    in_hand = result.segment_states[2].object_poses[0, :3]
    off = float(np.linalg.norm(in_hand - [0.2, 0.1, 0.16]))
    require(off < 5e-3, f"the held object is {1e3 * off:.1f} mm away from where the hand is")
    after = result.final_state.object_poses[0]
    left = float(np.linalg.norm(after[:2] - [0.2, 0.1]))
    require(left < 1e-2, f"the object was put down {1e3 * left:.1f} mm away")
    require(abs(after[2] - 0.06) < 5e-3, "the object was not let go")
    return f"{1e3 * off:.2f} mm"


def tracking(bench: Bench) -> str:
    start = tool(0.0, 0.0, 1.0)
    path = motion(line(start, start + tool(0.5, 0.3, 0.2), 0.5))
    problem = on_a_board(start=start)
    options = RolloutOptions(trace_step=0.02)
    result = bench.make(problem, bench.arm, ()).rollout(problem.initial, path, options=options)
    trace = result.trace
    require(trace is not None, "a trace was asked for")
    assert trace is not None
    wanted = path.segments[0].trajectory.at(trace.times)
    lag = float(np.abs(trace.joints - wanted).max())
    require(lag < 0.02, f"the arm lags by {1e3 * lag:.1f} mm (most 20)")
    return f"{1e3 * lag:.2f} mm"


def stall(bench: Bench) -> str:
    start = tool(0.0, 0.0, 0.3)
    wall = Fixture("wall", Box(np.array([0.1, 1.0, 1.0])), make_pose([0.2, 0.0, 0.5]))
    problem = on_a_board(start=start, fixtures=[wall])
    drive = motion(line(start, start + tool(0.6, 0.0, 0.0), 0.4))
    result = bench.make(problem, bench.arm, ()).rollout(problem.initial, drive, options=ALL)
    require(result.stalled, "the arm drives into a wall and is not reported as stalled")
    where = float(result.final_state.joint_positions[0])
    require(where < 0.25, f"the arm went {1e2 * (where - 0.13):.0f} cm into the wall")
    require(result.duration < drive.duration, "a stalled rollout went on to the end")
    return f"after {result.duration:.2f} s"


def half_friction(bench: Bench) -> str:
    (whole,) = slide_distances(bench, (0.0,)).values()
    half = ParameterOverrides({}, {"b0": FRICTION / 2.0})
    (longer,) = slide_distances(bench, (0.0,), half).values()
    ratio = longer / whole
    require(1.8 < ratio < 2.2, f"half the friction: {ratio:.2f} times as far, not 2")
    return f"{ratio:.2f} times as far"


def double_mass(bench: Bench) -> str:
    """A box that was pushed and slides hits another: the heavier it is, the farther that goes."""
    start = tool(-0.30, 0.0, 0.005)
    problem = on_a_board(
        placed(box("one", (0.12, 0.12, 0.06), 0.3, 0.2), -0.21, 0.0),
        placed(box("two", (0.12, 0.12, 0.06), 0.3, 0.2), 0.03, 0.0),
        start=start,
    )
    end = start + 0.12 * heading(0.0)
    shove = motion(line(start, end, 0.8), _stay(end, 0.6))
    model = bench.make(problem, bench.arm, ())
    far = [
        float(model.rollout(problem.initial, shove, parameters=p).final_state.object_poses[1, 0])
        for p in (None, ParameterOverrides({"one": 0.6}))
    ]
    require(far[0] > 0.04, f"the other box moved by {1e3 * (far[0] - 0.03):.1f} mm only")
    ratio = (far[1] - 0.03) / (far[0] - 0.03)
    require(ratio > 1.25, f"a box of twice the mass shoves another {ratio:.2f} times as far")
    return f"{ratio:.2f} times as far"


def _largest_change(problem: Problem, final: SceneState) -> tuple[float, float]:
    """Largest shift (m) and turn (degrees) of any object."""
    before, after = problem.initial.object_poses, final.object_poses
    shift = float(np.linalg.norm(after[:, :3] - before[:, :3], axis=1).max())
    overlap = np.abs((after[:, 3:] * before[:, 3:]).sum(axis=1))
    turn = float(np.degrees(2.0 * np.arccos(np.clip(overlap, 0.0, 1.0))).max())
    return shift, turn
