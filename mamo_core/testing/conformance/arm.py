"""The arm does what it is told, and holds what it is given."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.robots.kinematics import link_transforms
from mamo_core.robots.library import load_arm
from mamo_core.testing.conformance.bench import Bench, require
from mamo_core.testing.conformance.scenery import ALL, box, line, motion, on_a_board, placed, tool
from mamo_core.types.geometry import Array, Box, make_pose, matrix_from_pose
from mamo_core.types.problem import Problem
from mamo_core.types.scene import Fixture, SceneState

FK_TOLERANCE = 1e-6


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
