"""Seeded problems of thesis chapter 3: reach for an object on a table or in a refrigerator.

Objects are drawn from the YCB set (``ycb``) with replacement, upright, at uniform positions and
yaws, at least 1 cm apart; their masses are the set's, their friction is U(0.5, 1.1). The goal is
one pre-grasp pose of an immovable that fits into the hand (3.5.1): it is the target and counts as
one of the immovables. The thesis does not say how that pose was chosen; here it is drawn from
those default grasps of the target that do not come from behind.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from mamo_core.errors import InputError, suggestion
from mamo_core.problems.drawing import Classify, first_fitting
from mamo_core.problems.footprints import Footprint, apart, extents, footprint
from mamo_core.problems.grasps import default_grasps
from mamo_core.problems.importers import HOME, ROBOT
from mamo_core.problems.layouts import LAYOUTS, Layout
from mamo_core.problems.ycb import CATALOGUE, YcbObject
from mamo_core.robots.grasps import hand_of
from mamo_core.types.geometry import Array, make_pose, matrix_from_pose, yaw_of
from mamo_core.types.problem import Grasp, Problem, Task
from mamo_core.types.scene import Mobility, Scene, SceneObject, SceneState

GAP = 0.01
"""Least distance of two objects, m."""

FRICTION = (0.5, 1.1)

_MISSES = 100
_SCENE_DRAWS = 20


def generate_workspace(
    workspace: str,
    *,
    seed: int,
    movables: int | None = None,
    immovables: int | None = None,
    classify: Classify | None = None,
    max_draws: int = 300,
) -> Problem:
    """A reach in one of ``LAYOUTS``; a function of its arguments.

    ``movables`` and ``immovables`` (the target among them) default to what the thesis uses: 6 and
    6 on the table, 3 and 2 in the refrigerator. Scenes are drawn until ``classify`` says that the
    pre-grasp pose can be reached when the movables are ignored.

    Raises:
        InputError: no such workspace or number, or nothing that fits within ``max_draws`` scenes.
    """
    if workspace not in LAYOUTS:
        raise InputError(f"workspace {workspace!r} is not known{suggestion(workspace, LAYOUTS)}")
    layout = LAYOUTS[workspace]
    movables = layout.movables if movables is None else movables
    immovables = layout.immovables if immovables is None else immovables
    _check_numbers(seed, movables, immovables)
    name = f"{workspace}_{movables}_{immovables}_seed{seed}"
    # The name keeps the streams of the workspaces apart.
    rng = np.random.default_rng([*workspace.encode(), seed, movables, immovables])

    def draw() -> Problem:
        return _draw(layout, name, movables, immovables, rng)

    return first_fitting(name, draw, classify, lambda in_the_way: True, max_draws)


def _check_numbers(seed: int, movables: int, immovables: int) -> None:
    for what, value, least in (
        ("movables", movables, 0),
        ("immovables", immovables, 1),
        ("seed", seed, 0),
    ):
        if value < least:
            raise InputError(f"{what}: {value}, expected {least} or more")


def _draw(
    layout: Layout, name: str, movables: int, immovables: int, rng: np.random.Generator
) -> Problem:
    for _ in range(_SCENE_DRAWS):
        items = [CATALOGUE[i] for i in rng.integers(len(CATALOGUE), size=immovables + movables)]
        poses = _poses(layout, items, rng)
        target = _target(items[:immovables], rng)
        if poses is None or target is None:
            continue
        grasps = _grasps_from_the_front(items[target], poses[target])
        if grasps:
            chosen = grasps[rng.integers(len(grasps))]
            mobilities = _mobilities(movables, immovables, target)
            return _problem(layout, name, _objects(items, mobilities, rng), poses, chosen)
    raise InputError(
        f"{name}: no room for {movables} movables and {immovables} immovables in {_SCENE_DRAWS} "
        "attempts"
    )


def _poses(layout: Layout, items: Sequence[YcbObject], rng: np.random.Generator) -> Array | None:
    """Poses (n, 7) that keep their distance, or None if there is no room."""
    poses: list[Array] = []
    placed: list[Footprint] = []
    for item in items:
        for _ in range(_MISSES):
            pose = _pose(layout, item, rng)
            outline = footprint(item.shape, pose)
            if _inside(layout, outline) and all(apart(outline, other, GAP) for other in placed):
                break
        else:
            return None
        poses.append(pose)
        placed.append(outline)
    return np.array(poses)


def _pose(layout: Layout, item: YcbObject, rng: np.random.Generator) -> Array:
    x, y = (round(float(v), 6) for v in rng.uniform(layout.lower[:2], layout.upper[:2]))
    yaw = round(float(rng.uniform(0.0, 2.0 * math.pi)), 6)
    return make_pose([x, y, round(layout.lower[2] + item.shape.height / 2.0, 7)], yaw)


def _inside(layout: Layout, outline: Footprint) -> bool:
    x0, y0, x1, y1 = extents(outline)
    lower, upper, gap = layout.lower, layout.upper, layout.gap
    # The front is open: nothing is kept away from it.
    return x0 >= lower[0] and y0 >= lower[1] + gap and x1 <= upper[0] - gap and y1 <= upper[1] - gap


def _target(immovables: Sequence[YcbObject], rng: np.random.Generator) -> int | None:
    """Place of an object that fits into the hand, each as likely, or None if there is none."""
    fitting = [i for i, item in enumerate(immovables) if _grasps(item, first_yaw=0.0)]
    return fitting[rng.integers(len(fitting))] if fitting else None


def _grasps(item: YcbObject, first_yaw: float) -> tuple[Grasp, ...]:
    placeholder = SceneObject(item.name, item.shape, Mobility.TARGET, item.mass, 1.0)
    return default_grasps(placeholder, hand_of(ROBOT), first_yaw=first_yaw)


def _grasps_from_the_front(item: YcbObject, pose: Array) -> list[Grasp]:
    """Grasps for which the hand does not point towards the open side (-x)."""
    T_world_object = matrix_from_pose(pose)
    grasps = _grasps(item, first_yaw=-yaw_of(pose))
    return [g for g in grasps if (T_world_object @ g.T_object_pregrasp)[0, 0] >= 0.0]


def _mobilities(movables: int, immovables: int, target: int) -> list[Mobility]:
    kinds = [Mobility.IMMOVABLE] * immovables + [Mobility.MOVABLE] * movables
    kinds[target] = Mobility.TARGET
    return kinds


def _objects(
    items: Sequence[YcbObject], mobilities: Sequence[Mobility], rng: np.random.Generator
) -> tuple[SceneObject, ...]:
    frictions = [round(float(v), 6) for v in rng.uniform(*FRICTION, size=len(items))]
    return tuple(
        SceneObject(name, item.shape, mobility, item.mass, friction)
        for name, item, mobility, friction in zip(
            _names(items), items, mobilities, frictions, strict=True
        )
    )


def _names(items: Sequence[YcbObject]) -> list[str]:
    """Names of the set; a second object of the same kind is called ``mug_2``."""
    seen: Counter[str] = Counter()
    names = []
    for item in items:
        seen[item.name] += 1
        number = seen[item.name]
        names.append(item.name if number == 1 else f"{item.name}_{number}")
    return names


def _problem(
    layout: Layout, name: str, objects: tuple[SceneObject, ...], poses: Array, grasp: Grasp
) -> Problem:
    scene = Scene(
        robot=ROBOT,
        T_world_base=make_pose([0.0, 0.0, 0.0]),
        fixtures=layout.fixtures(),
        objects=objects,
        workspace=layout.workspace(),
    )
    home = np.array(HOME)
    return Problem(
        name=name,
        scene=scene,
        initial=SceneState(home, poses),
        home=home,
        grasps=(grasp,),
        task=Task.REACH,
    )
