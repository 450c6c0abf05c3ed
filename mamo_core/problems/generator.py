"""Seeded shelf scenes distributed as those published with the thesis.

The distribution was read off the 377 published scenes: half extents and radii are U(0, 0.08)
raised to 0.03 m (so 3/8 of them are exactly 0.03), half heights of boxes U(0, 0.155) raised to
0.09, heights of cylinders U(0, 0.2) raised to 0.15, boxes and cylinders are equally likely before
rejection. Centres are uniform, inset by the extents as if the yaw were 0 (so turned boxes overhang
the open front); an object that comes within 1 cm of another or of a wall is drawn anew, sizes
included. Immovables come before movables. The target is the first immovable that is narrow enough
and in reach.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mamo_core.errors import InputError, suggestion
from mamo_core.problems.documents import automatic_grasps
from mamo_core.problems.drawing import Classify, first_fitting
from mamo_core.problems.footprints import Footprint, apart, extents, footprint
from mamo_core.problems.importers import (
    HOME,
    INTERIOR_LOWER,
    INTERIOR_UPPER,
    OVERHANG,
    ROBOT,
    thesis_workspace,
)
from mamo_core.robots.grasps import LEAST_CLEARANCE, hand_of
from mamo_core.types.geometry import Array, Box, Cylinder, Shape, make_pose
from mamo_core.types.problem import Problem
from mamo_core.types.scene import (
    MINIMUM_MASS,
    Fixture,
    Mobility,
    Scene,
    SceneObject,
    SceneState,
)

LEVELS = ("easy", "medium", "hard")
"""1, 2 and more than 2 movables in the initial NGR."""

IMMOVABLES = 4
SMALLEST, LARGEST = 0.03, 0.08
BOX_HALF_HEIGHT = (0.09, 0.155)
CYLINDER_HEIGHT = (0.15, 0.20)
HEAVIEST = 0.5
FRICTION = (0.8, 1.2)
GAP = 0.01
GRASPABLE = 0.045
"""Half width of the widest published target, m; ours must also fit our gripper."""
REACH = (0.66, 0.82)
"""Published targets are uniform in x up to the first and thin out to none at the second, m."""

_FIRST_ID = 6
_MISSES = 500
_SCENE_DRAWS = 10

_BOARDS: tuple[tuple[str, tuple[float, ...], tuple[float, ...]], ...] = (
    ("base", (0.78, -0.50, 0.75), (0.60, 0.80, 0.04)),
    ("back", (1.10, -0.50, 0.93), (0.04, 0.80, 0.40)),
    ("top", (0.78, -0.50, 1.11), (0.60, 0.80, 0.04)),
    ("right", (0.80, -0.92, 0.93), (0.64, 0.04, 0.40)),
    ("left", (0.80, -0.08, 0.93), (0.64, 0.04, 0.40)),
)


def generate_shelf(
    *,
    movables: int,
    seed: int,
    level: str | None = None,
    classify: Classify | None = None,
    max_draws: int = 300,
) -> Problem:
    """A shelf with 4 immovables, the target and so many ``movables``; a function of its arguments.

    Scenes are drawn until ``classify`` says that the target can be retrieved when the movables are
    ignored, and that as many movables are in the way as ``level`` (None: any number) wants.

    Raises:
        InputError: no such level, or nothing that fits within ``max_draws`` scenes.
    """
    _check_request(movables, seed, level, classify)
    rng = np.random.default_rng([seed, movables])
    name = "_".join(["shelf", str(movables), *([level] if level else []), f"seed{seed}"])

    def draw() -> Problem:
        return _draw(movables, name, rng)

    def wanted(in_the_way: int) -> bool:
        return level in (None, level_of(in_the_way))

    return first_fitting(name, draw, classify, wanted, max_draws)


def level_of(in_the_way: int) -> str | None:
    """The level of a scene with so many movables in the initial NGR; None if there are none."""
    return None if in_the_way <= 0 else LEVELS[min(in_the_way, len(LEVELS)) - 1]


def _check_request(movables: int, seed: int, level: str | None, classify: Classify | None) -> None:
    if movables < 0:
        raise InputError(f"movables: {movables}, expected 0 or more")
    if seed < 0:
        raise InputError(f"seed: {seed}, expected 0 or more")
    if level is not None and level not in LEVELS:
        raise InputError(f"level {level!r} is not known{suggestion(level, LEVELS)}")
    if level is not None and classify is None:
        raise ValueError("generate_shelf: a level needs 'classify'")


def _draw(movables: int, name: str, rng: np.random.Generator) -> Problem:
    for _ in range(_SCENE_DRAWS):
        bodies = _bodies(IMMOVABLES + 1 + movables, rng)
        if bodies is None:
            continue
        target = _first_graspable(bodies[: IMMOVABLES + 1], float(rng.uniform(*REACH)))
        if target is not None:
            return _problem(name, bodies, target, rng)
    raise InputError(f"{name}: no room for {movables} movables in {_SCENE_DRAWS} attempts")


def _bodies(count: int, rng: np.random.Generator) -> list[tuple[Shape, Array]] | None:
    """Shapes and poses that keep their distance, or None if the shelf is full."""
    bodies: list[tuple[Shape, Array]] = []
    placed: list[Footprint] = []
    misses = 0
    while len(bodies) < count and misses < _MISSES:
        shape, pose = _body(rng)
        outline = footprint(shape, pose)
        if _within_walls(outline) and all(apart(outline, other, GAP) for other in placed):
            bodies.append((shape, pose))
            placed.append(outline)
            misses = 0
        else:
            misses += 1
    return bodies if len(bodies) == count else None


def _body(rng: np.random.Generator) -> tuple[Shape, Array]:
    box = bool(rng.random() < 0.5)
    hx, hy = (_raised(rng, SMALLEST, LARGEST) for _ in range(2))
    half_height = _raised(rng, *BOX_HALF_HEIGHT)
    height = _raised(rng, *CYLINDER_HEIGHT)
    yaw = round(float(rng.uniform(0.0, 2.0 * math.pi)), 6)
    shape: Shape = Box(np.array([2 * hx, 2 * hy, 2 * half_height])) if box else Cylinder(hx, height)
    inset = np.array([hx, hy if box else hx])
    center = rng.uniform(INTERIOR_LOWER[:2] + inset, INTERIOR_UPPER[:2] - inset)
    x, y = (round(float(v), 6) for v in center)
    return shape, make_pose([x, y, round(INTERIOR_LOWER[2] + shape.height / 2.0, 7)], yaw)


def _raised(rng: np.random.Generator, least: float, most: float) -> float:
    """U(0, ``most``), raised to ``least``."""
    return max(least, round(float(rng.uniform(0.0, most)), 6))


def _within_walls(outline: Footprint) -> bool:
    x0, y0, x1, y1 = extents(outline)
    return (
        x0 >= INTERIOR_LOWER[0] - OVERHANG
        and y0 >= INTERIOR_LOWER[1] + GAP
        and x1 <= INTERIOR_UPPER[0] - GAP
        and y1 <= INTERIOR_UPPER[1] - GAP
    )


def _first_graspable(bodies: Sequence[tuple[Shape, Array]], farthest: float) -> int | None:
    widest = min(2.0 * GRASPABLE, hand_of(ROBOT).opening - LEAST_CLEARANCE)
    for i, (shape, pose) in enumerate(bodies):
        width = shape.size[:2].min() if isinstance(shape, Box) else 2.0 * shape.radius
        if width < widest and pose[0] <= farthest:
            return i
    return None


def _problem(
    name: str, bodies: list[tuple[Shape, Array]], target: int, rng: np.random.Generator
) -> Problem:
    objects = tuple(
        SceneObject(
            f"o{_FIRST_ID + i}",
            shape,
            _mobility(i, target),
            round(float(rng.uniform(MINIMUM_MASS, HEAVIEST)), 6),
            round(float(rng.uniform(*FRICTION)), 6),
        )
        for i, (shape, _) in enumerate(bodies)
    )
    scene = Scene(
        robot=ROBOT,
        T_world_base=make_pose([0.0, 0.0, 0.0]),
        fixtures=tuple(
            Fixture(board, Box(np.array(size)), make_pose(position))
            for board, position, size in _BOARDS
        ),
        objects=objects,
        workspace=thesis_workspace(),
    )
    home = np.array(HOME)
    return Problem(
        name=name,
        scene=scene,
        initial=SceneState(home, np.array([pose for _, pose in bodies])),
        home=home,
        grasps=automatic_grasps(scene, bodies[target][1]),
    )


def _mobility(place: int, target: int) -> Mobility:
    if place == target:
        return Mobility.TARGET
    return Mobility.IMMOVABLE if place <= IMMOVABLES else Mobility.MOVABLE
