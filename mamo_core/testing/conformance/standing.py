"""Rest, stacks and tipping: objects stay, or fall, as they should."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mamo_core.constraints.standard import ContactConstraint
from mamo_core.testing.conformance.bench import Bench, require
from mamo_core.testing.conformance.scenery import (
    ALL,
    FRICTION,
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
from mamo_core.types.geometry import Array, Box, Cylinder, make_pose, quat_from_rotation
from mamo_core.types.problem import Problem
from mamo_core.types.scene import Fixture, Mobility, SceneObject, SceneState

DRIFT, TURN = 2e-4, 0.2
"""Objects at rest stay within this for 5 s: m, degrees."""

STACK_DRIFT, STACK_TURN = 2e-3, 1.0
_SIDES = ((1, 1), (1, -1), (-1, 1), (-1, -1))


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


def immovables(bench: Bench) -> str:
    """A post stands 5 cm nearer than in the problem: that is where the foot meets it."""
    side, nearer = 0.08, 0.05
    post = replace(box("post", (side, side, side)), mobility=Mobility.IMMOVABLE)
    start = tool(-0.2, 0.0, 0.02)
    problem = on_a_board(placed(post, 0.0, 0.0), start=start)
    poses = np.array(problem.initial.object_poses)
    poses[0, 0] -= nearer
    model = bench.make(problem, bench.arm, (ContactConstraint(problem),))
    # So far that the thin fingers of engines without a foot meet it, too.
    push = motion(line(start, start + 0.17 * heading(0.0), 0.1))
    meetings = [
        model.rollout(SceneState(start, where), push, options=ALL).violations
        for where in (problem.initial.object_poses, poses)
    ]
    require(all(meetings), "the foot meets a post, and no contact was reported")
    sooner = meetings[0][0].time - meetings[1][0].time
    expected = nearer / 0.1
    require(abs(sooner - expected) < 0.06, f"met {sooner:.2f} s sooner, expected {expected:.2f}")
    return f"{sooner:.2f} of {expected:.2f} s sooner"


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


def _largest_change(problem: Problem, final: SceneState) -> tuple[float, float]:
    """Largest shift (m) and turn (degrees) of any object."""
    before, after = problem.initial.object_poses, final.object_poses
    shift = float(np.linalg.norm(after[:, :3] - before[:, :3], axis=1).max())
    overlap = np.abs((after[:, 3:] * before[:, 3:]).sum(axis=1))
    turn = float(np.degrees(2.0 * np.arccos(np.clip(overlap, 0.0, 1.0))).max())
    return shift, turn
