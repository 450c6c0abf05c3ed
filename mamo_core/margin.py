"""The margin of a plan: how often it holds where the world is not quite what its problem says."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from mamo_core.interfaces.transition_model import TransitionModel
from mamo_core.problems.footprints import footprint, separation
from mamo_core.robots.model import ArmModel
from mamo_core.types.deviation import Deviation, moved, other_parameters
from mamo_core.types.geometry import Array, Shape
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem, Task
from mamo_core.types.scene import SceneState
from mamo_core.types.solution import Plan
from mamo_core.verify_task import check_retrieved

DEVIATIONS: Mapping[str, Deviation] = MappingProxyType(
    {
        "0.1 mm": Deviation(1e-4, float(np.radians(0.05))),
        "1 mm": Deviation(1e-3, float(np.radians(0.5))),
        "5 mm, 3 deg, 20 %": Deviation(5e-3, float(np.radians(3.0)), 0.2),
    }
)
"""What is asked of every plan: a hair's breadth, good sensors, and those of most."""

WORLDS = 10
"""Worlds of each deviation."""

_SEED = 0
_DRAWS = 20


def margin_of(
    problem: Problem,
    plan: Plan,
    model: TransitionModel,
    robot: ArmModel,
    tell: Callable[[str], None] = lambda text: None,
) -> dict[str, float]:
    """By the name of the deviation, the share of worlds in which the whole plan holds."""
    shares = {}
    for name, deviation in DEVIATIONS.items():
        tell(f"executing the plan in {WORLDS} worlds that are {name} off")
        shares[name] = share_that_holds(problem, plan, model, robot, deviation, WORLDS)
    return shares


def share_that_holds(
    problem: Problem,
    plan: Plan,
    model: TransitionModel,
    robot: ArmModel,
    deviation: Deviation,
    worlds: int,
) -> float:
    """The share of ``worlds`` drawn worlds in which the plan, executed blindly, holds.

    It holds if nothing is broken and the target ends in the hand.
    """
    rng = np.random.default_rng(_SEED)
    return float(
        np.mean([_holds(problem, plan, model, robot, deviation, rng) for _ in range(worlds)])
    )


def _holds(
    problem: Problem,
    plan: Plan,
    model: TransitionModel,
    robot: ArmModel,
    deviation: Deviation,
    rng: np.random.Generator,
) -> bool:
    whole = Motion(tuple(s for m in plan.motions for s in m.segments), plan.motions[0].opening)
    start = SceneState(problem.initial.joint_positions, possible_poses(problem, deviation, rng))
    parameters = other_parameters(problem, deviation, rng)
    result = model.rollout(start, whole, parameters=parameters)
    if not result.valid or problem.task is Task.REACH:
        return result.valid
    return not check_retrieved(problem, whole.segments, result, robot)


def possible_poses(problem: Problem, deviation: Deviation, rng: np.random.Generator) -> Array:
    """Poses (n, 7) near the initial ones at which no two things are nearer in each other.

    An object for which no such place is drawn stays where it is.
    """
    shapes = [item.shape for item in problem.scene.objects]
    poses = np.array(problem.initial.object_poses)
    for number in range(len(poses)):
        before = _closeness(problem, shapes, poses, number)
        for _ in range(_DRAWS):
            tried = np.array(poses)
            tried[number] = moved(poses[number : number + 1], deviation, rng)[0]
            if (_closeness(problem, shapes, tried, number) >= np.minimum(before, 0.0)).all():
                poses = tried
                break
    return poses


def _closeness(problem: Problem, shapes: list[Shape], poses: Array, number: int) -> Array:
    """Distances (m) of one object to all others and to fixtures at its height, seen from above."""
    own = footprint(shapes[number], poses[number])
    others = [
        separation(own, footprint(shape, pose)).distance
        for k, (shape, pose) in enumerate(zip(shapes, poses, strict=True))
        if k != number
    ]
    half, height = shapes[number].height / 2.0, float(poses[number, 2])
    walls = [
        separation(own, footprint(fixture.shape, fixture.pose)).distance
        for fixture in problem.scene.fixtures
        if abs(float(fixture.pose[2]) - height) < half + fixture.shape.height / 2.0 - 1e-3
    ]
    return np.array([*others, *walls])
