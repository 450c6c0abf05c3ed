"""Coulomb friction and inertia: figures that can be computed by hand."""

from __future__ import annotations

import numpy as np

from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.testing.conformance.bench import Bench, require
from mamo_core.testing.conformance.scenery import (
    FRICTION,
    GRAVITY,
    box,
    heading,
    line,
    motion,
    on_a_board,
    placed,
    still,
    tool,
)
from mamo_core.testing.gantry_arm import FOOT
from mamo_core.types.geometry import Array, BoolArray, Box, make_pose, quat_from_rotation
from mamo_core.types.motion import MotionSegment
from mamo_core.types.rollout import ParameterOverrides
from mamo_core.types.scene import Fixture

SPEED = 0.5
SLIDE = 0.06
"""Sliding distances are right within this share."""

_GRID = 0.005
_ON_TOP = 0.3
"""Coefficients measured on a box that shakes a little are right within this share."""


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
