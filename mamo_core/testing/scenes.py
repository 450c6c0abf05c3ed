"""Tiny scenes for the gantry with known answers, so that searches are tested in milliseconds."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mamo_core.testing.gantry import GANTRY
from mamo_core.types.geometry import Box, Cylinder, make_pose
from mamo_core.types.problem import Grasp, Problem, Task
from mamo_core.types.scene import Fixture, Mobility, Scene, SceneObject, SceneState, Workspace

HOME = np.array([-0.2, 0.0, 0.05, 0.0])
"""The gantry's start and goal: in front of the open side, m and rad."""

TARGET_XY = (0.45, 0.0)
OPENING = 0.07
"""Gap between the fingers of the only grasp: the target is 6 cm wide, m."""

IN_THE_PREGRASP = (0.36, 0.055)
"""Around the left finger at the pre-grasp, m."""

LOW = 0.03
"""Height of what the hand passes over, m."""


@dataclass(frozen=True, eq=False)
class TinyScene:
    """``blockers``: movables that stand in the way; ``solvable``: pushes can clear it."""

    problem: Problem
    blockers: tuple[str, ...]
    solvable: bool = True


def clear_scene() -> TinyScene:
    """Nothing is in the way."""
    return TinyScene(_problem("clear", {"a": (0.25, 0.25)}), ())


def one_blocker() -> TinyScene:
    """One box stands in the middle of the way, with room on both sides."""
    return TinyScene(_problem("one_blocker", {"a": (0.25, 0.0), "b": (0.45, 0.3)}), ("a",))


def two_blockers() -> TinyScene:
    """Two boxes stand in the way, one behind the other."""
    places = {"a": (0.15, 0.02), "b": (0.30, -0.02), "c": (0.5, 0.32)}
    return TinyScene(_problem("two_blockers", places), ("a", "b"))


def walled_in() -> TinyScene:
    """An immovable box stands in the way: no plan exists."""
    problem = _problem("walled_in", {"a": (0.25, 0.25)}, immovables={"w": (0.25, 0.0)})
    return TinyScene(problem, (), solvable=False)


def reach_past(scene: TinyScene) -> TinyScene:
    """The same, but the hand is to go where the approach to the target begins."""
    name = f"reach_{scene.problem.name}"
    return replace(scene, problem=replace(scene.problem, name=name, task=Task.REACH))


def reach_by_pushing() -> TinyScene:
    """To reach: a box stands where a finger has to go, with room behind it."""
    return reach_past(TinyScene(_problem("by_pushing", {"a": IN_THE_PREGRASP}), ("a",)))


def reach_without_room() -> TinyScene:
    """To reach: that box again, but immovable ones around it leave no room to push it anywhere."""
    walls = {"e": (0.43, 0.065), "w": (0.285, 0.065), "n": (0.36, 0.135)}
    step = {"s": (0.36, -0.015)}
    problem = _problem("without_room", {"a": IN_THE_PREGRASP}, walls, low=step)
    return reach_past(TinyScene(problem, ("a",), solvable=False))


def reach_past_a_corner() -> TinyScene:
    """To reach: on the straight way a finger pushes a box into an immovable one; others go round.

    Another movable stands aside.
    """
    places = {"a": (0.2, 0.045), "b": (0.3, 0.25)}
    return reach_past(TinyScene(_problem("corner", places, {"w": (0.275, 0.045)}), ("a",)))


def reach_between_corners() -> TinyScene:
    """To reach: the same for both fingers, one box each."""
    places = {"a": (0.2, 0.045), "b": (0.2, -0.045)}
    walls = {"v": (0.26, 0.1), "w": (0.26, -0.1)}
    return reach_past(TinyScene(_problem("corners", places, walls), ("a", "b")))


def _problem(
    name: str,
    movables: dict[str, tuple[float, float]],
    immovables: dict[str, tuple[float, float]] | None = None,
    low: dict[str, tuple[float, float]] | None = None,
) -> Problem:
    """``low``: immovables that the hand passes over."""
    placed = {**movables, **(immovables or {}), **(low or {})}
    objects = [
        SceneObject(
            n,
            Box(np.array([0.06, 0.06, LOW if n in (low or {}) else 0.12])),
            Mobility.MOVABLE if n in movables else Mobility.IMMOVABLE,
            0.2,
            0.5,
        )
        for n in placed
    ]
    objects.append(SceneObject("target", Cylinder(0.03, 0.12), Mobility.TARGET, 0.2, 0.5))
    poses = [
        make_pose([x, y, item.shape.height / 2.0])
        for item, (x, y) in zip(objects, (*placed.values(), TARGET_XY), strict=True)
    ]
    floor = Fixture("floor", Box(np.array([0.6, 0.8, 0.04])), make_pose([0.3, 0.0, -0.02]))
    scene = Scene(
        robot=GANTRY,
        T_world_base=make_pose([0.0, 0.0, 0.0]),
        fixtures=(floor,),
        objects=tuple(objects),
        workspace=Workspace(np.array([0.0, -0.4, 0.0]), np.array([0.6, 0.4, 0.3])),
    )
    grasp = Grasp(make_pose([0.0, 0.0, -0.01]), approach=0.1, opening=OPENING)
    return Problem(name, scene, SceneState(HOME, np.array(poses)), HOME, (grasp,))
