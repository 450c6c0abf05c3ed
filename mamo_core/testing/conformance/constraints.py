"""Every interaction constraint fires when it should, at a time known beforehand, and only then."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mamo_core.constraints.options import PenetrationOptions
from mamo_core.constraints.standard import ContactConstraint, PenetrationConstraint
from mamo_core.testing.conformance.bench import Bench, require
from mamo_core.testing.conformance.scenery import (
    ALL,
    box,
    line,
    motion,
    on_a_board,
    placed,
    still,
    tool,
)
from mamo_core.testing.gantry_arm import FOOT, POST, POST_SIDE
from mamo_core.testing.transition_cases import standard_constraints
from mamo_core.types.geometry import Box, make_pose
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import RolloutResult, Violation
from mamo_core.types.scene import Fixture, Mobility, SceneObject

ONSET = 0.06
"""An onset may be reported this long (s) before or after the computed time."""

SPEED, RAMP = 0.2, 0.1
SIDE = 0.08


def robot_touches_immovable(bench: Bench) -> str:
    item = replace(_block("post"), mobility=Mobility.IMMOVABLE)
    return _contact_by_the_foot(bench, on_a_board(placed(item, 0.0, 0.0), start=_START), "post")


def robot_touches_target(bench: Bench) -> str:
    item = replace(_block("target"), mobility=Mobility.TARGET)
    problem = on_a_board(placed(item, 0.0, 0.0), start=_START)
    return _contact_by_the_foot(bench, problem, "target")


def robot_touches_fixture(bench: Bench) -> str:
    rail = Fixture("rail", Box(np.full(3, SIDE)), make_pose([0.0, 0.0, SIDE / 2.0]))
    return _contact_by_the_foot(bench, on_a_board(start=_START, fixtures=[rail]), "rail")


def robot_touches_itself(bench: Bench) -> str:
    """The foot is driven into the robot's own post."""
    away = 0.1
    front = POST[0] - POST_SIDE / 2.0
    start = tool(front - away - FOOT / 2.0, POST[1], POST[2])
    result = _run(
        bench, on_a_board(start=start), motion(line(start, start + tool(0.14, 0, 0), SPEED))
    )
    found = _of_kind(result, "contact", "robot")
    require(found.other == "robot", f"{found}, expected robot - robot")
    return _onset(found, _time_at(away))


def object_touches_immovable(bench: Bench) -> str:
    return _contact_by_a_block(bench, "post", Mobility.IMMOVABLE)


def object_touches_target(bench: Bench) -> str:
    return _contact_by_a_block(bench, "target", Mobility.TARGET)


def clearance(bench: Bench) -> str:
    """The foot pushes a block to 1 cm in front of a post, which counts as touched 2 cm before; one
    that stands 2 cm beside the block from the start is not touched, and nothing else changes."""
    clear, away = 0.02, 0.06
    post, beside = (replace(_block(n), mobility=Mobility.IMMOVABLE) for n in ("post", "beside"))
    problem = on_a_board(
        placed(_block("b"), 0.0, 0.0),
        placed(post, SIDE + away, 0.0),
        placed(beside, 0.0, SIDE + clear),
        start=_START,
    )
    constraints = (ContactConstraint(problem, clear), *standard_constraints(problem)[1:])
    model = bench.make(problem, bench.arm, constraints)
    drive = _drive(_gap(0.0) + away - clear / 2.0)
    near = model.rollout(problem.initial, drive, options=ALL)
    found = _of_kind(near, "contact", "b")
    require(found.other == "post", f"{found}, expected b - post")
    plain = _run(bench, problem, drive)
    require(not plain.violations, f"{[str(v) for v in plain.violations]} without a clearance")
    same = np.array_equal(near.final_state.object_poses, plain.final_state.object_poses)
    require(same, "what is only near was pushed")
    return _onset(found, _time_at(_gap(0.0) + away - clear))


def tilt(bench: Bench) -> str:
    item = box("tower", (0.06, 0.10, 0.24), friction=0.9)
    start = tool(-0.10, 0.0, 0.18)
    problem = on_a_board(placed(item, 0.0, 0.0), start=start)
    result = _run(bench, problem, motion(line(start, start + tool(0.2, 0.0, 0.0), SPEED)))
    found = _of_kind(result, "tilt", "tower")
    require(found.value > found.limit, f"reported at {found.value:.3f} rad, below the limit")
    require(found.value < found.limit + 0.1, f"reported late, at {found.value:.3f} rad")
    kinds = {violation.constraint for violation in result.violations}
    require("contact" not in kinds, "a contact violation, but nothing immovable was touched")
    return f"at {np.degrees(found.value):.1f} degrees"


def speed(bench: Bench) -> str:
    """A held object is moved too fast; its speed is that of the hand."""
    ramp, top = 0.5, 1.5
    start = tool(0.0, 0.0, 0.5)
    item = box("b", (0.06, 0.06, 0.12))
    problem = on_a_board((item, make_pose([0.0, 0.0, 0.4])), start=start)
    fast = motion(line(start, start + tool(0.9, 0.0, 0.0), top, held="b", ramp=ramp))
    result = _run(bench, problem, fast)
    return _onset(_of_kind(result, "speed", "b"), ramp / top)


def bounds(bench: Bench) -> str:
    """A block is pushed over the edge of a shelf and falls."""
    shelf = Fixture("shelf", Box(np.array([0.4, 0.4, 0.1])), make_pose([-0.2, 0.0, 0.55]))
    item = _block("b")
    start = tool(-0.22, 0.0, 0.605)
    problem = on_a_board(
        (item, make_pose([-0.12, 0.0, 0.60 + SIDE / 2.0])), start=start, fixtures=[shelf]
    )
    push = motion(line(start, start + tool(0.28, 0.0, 0.0), SPEED, settle=0.5))
    result = _run(bench, problem, push)
    falls = [v for v in result.violations if (v.constraint, v.subject) == ("bounds", "b")]
    require(falls, f"it fell, and only {[str(v) for v in result.violations]} was reported")
    found = falls[0]
    over = _time_at(-_gap(-0.12) + 0.12)
    require(found.time > over - ONSET, f"fallen at {found.time:.2f} s, before it is over the edge")
    require(found.time < over + 0.8, f"fallen at {found.time:.2f} s, the edge was at {over:.2f} s")
    return f"{found.time - over:.2f} s after its centre has passed the edge"


def penetration(bench: Bench) -> str:
    """A block begins 6 mm inside the board."""
    deep = 0.006
    item, pose = placed(_block("b"), 0.0, 0.0)
    problem = on_a_board((item, pose - np.array([0.0, 0.0, deep, 0.0, 0.0, 0.0, 0.0])))
    model = bench.make(problem, bench.arm, (PenetrationConstraint(problem, PenetrationOptions()),))
    result = model.rollout(problem.initial, still(0.1), options=ALL)
    found = _of_kind(result, "penetration", "b")
    require(found.other == "board", f"{found}, expected b - board")
    require(found.value < 1.1 * deep, f"{1e3 * found.value:.1f} mm, it began {1e3 * deep:g} deep")
    return f"{1e3 * found.value:.1f} of {1e3 * deep:g} mm"


def nothing_else(bench: Bench) -> None:
    """A free block is pushed slowly and low: no constraint has anything to say."""
    problem = on_a_board(placed(_block("b"), 0.0, 0.0), start=_START)
    result = _run(bench, problem, _drive())
    require(not result.violations, f"{[str(v) for v in result.violations]}")
    require(result.moved == ("b",), f"moved: {result.moved}")


_START = tool(-0.2, 0.0, 0.01)


def _block(name: str) -> SceneObject:
    return box(name, (SIDE, SIDE, SIDE), friction=0.4)


def _gap(x: float) -> float:
    """Distance (m) from the foot at its start to a block at x."""
    return x - SIDE / 2.0 - (float(_START[0]) + FOOT / 2.0)


def _time_at(distance: float) -> float:
    """When a motion with ``SPEED`` and ``RAMP`` has gone so far (m), s."""
    return RAMP / 2.0 + distance / SPEED


def _drive(way: float = 0.25) -> Motion:
    return motion(line(_START, _START + tool(way, 0.0, 0.0), SPEED, ramp=RAMP))


def _contact_by_the_foot(bench: Bench, problem: Problem, name: str) -> str:
    result = _run(bench, problem, _drive())
    found = _of_kind(result, "contact", "robot")
    require(found.other == name, f"{found}, expected robot - {name}")
    return _onset(found, _time_at(_gap(0.0)))


def _contact_by_a_block(bench: Bench, name: str, mobility: Mobility) -> str:
    """The foot pushes a block against another one."""
    away = 0.06
    stands = replace(_block(name), mobility=mobility)
    problem = on_a_board(
        placed(_block("b"), 0.0, 0.0), placed(stands, SIDE + away, 0.0), start=_START
    )
    result = _run(bench, problem, _drive())
    found = _of_kind(result, "contact", "b")
    require(found.other == name, f"{found}, expected b - {name}")
    return _onset(found, _time_at(_gap(0.0) + away))


def _run(bench: Bench, problem: Problem, drive: Motion) -> RolloutResult:
    model = bench.make(problem, bench.arm, standard_constraints(problem))
    return model.rollout(problem.initial, drive, options=ALL)


def _of_kind(result: RolloutResult, constraint: str, subject: str) -> Violation:
    """The first violation, which must be of this kind and subject."""
    require(result.violations, f"no violation at all, expected {constraint} of {subject}")
    first = result.violations[0]
    expected = (constraint, subject)
    require((first.constraint, first.subject) == expected, f"{first}, expected {expected}")
    return first


def _onset(found: Violation, expected: float) -> str:
    off = found.time - expected
    require(abs(off) < ONSET, f"{found}, expected at {expected:.3f} s")
    return f"{1e3 * off:+.0f} ms"
