"""What a plan's last motion sweeps, for pictures of plans whose file does not say it.

Searches have the region from their collision checker. Here it is drawn from the motion itself: the
arm's sphere covers and what is in the hand, along the trajectories.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mamo_core.robots.kinematics import link_transforms_along
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, Box, Cylinder, Shape, invert, matrix_from_pose
from mamo_core.types.motion import Motion
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.solution import Plan
from mamo_core.view.solids import shape_mesh

_CELL = 0.01
"""Size of a cell, m."""

_BORDER = 0.15
"""The map reaches so far beyond the workspace and what may stand out of it, m."""

_BEAT = 0.02
"""Time between the rows that are looked at, s: less than a cell, at the speed of a hand."""


def with_region(problem: Problem, plan: Plan, robot: ArmModel) -> Plan:
    """The plan with the region that its last motion sweeps, if it has none."""
    if plan.region is not None:
        return plan
    return replace(plan, region=swept_region(problem, _from_home(problem, plan.retrieval), robot))


def _from_home(problem: Problem, motion: Motion) -> Motion:
    """Without the way back home from the last action, which nothing has to make room for."""
    for number, segment in enumerate(motion.segments):
        if np.allclose(segment.trajectory.positions[0], problem.home, rtol=0.0, atol=1e-6):
            opening = motion.segments[number - 1].opening if number else motion.opening
            return Motion(motion.segments[number:], opening)
    return motion


def swept_region(problem: Problem, motion: Motion, robot: ArmModel) -> SweptRegion:
    """The height map over the workspace of what the arm and what it holds sweep.

    What is held stands where it does in the initial state until it is taken.
    """
    space = problem.scene.workspace
    border = space.overhang + _BORDER
    origin = space.lower[:2] - border
    cells = np.ceil((space.upper[:2] + border - origin) / _CELL).astype(np.int64)
    lowest = np.full((cells[0], cells[1]), np.inf)
    for spheres in _swept_spheres(problem, motion, robot):
        _stamp(lowest, origin, spheres[spheres[:, 2] - spheres[:, 3] < space.upper[2]])
    return SweptRegion(origin, _CELL, lowest, space.floor)


def _swept_spheres(problem: Problem, motion: Motion, robot: ArmModel) -> Iterator[Array]:
    """Spheres (k, 4) in the world, x, y, z, r: of each part, in each segment."""
    scene = problem.scene
    T_world_base = matrix_from_pose(scene.T_world_base)
    in_hand: dict[str, Array] = {}
    for segment in motion.segments:
        along = segment.trajectory
        times = np.linspace(0.0, along.duration, int(np.ceil(along.duration / _BEAT)) + 1)
        links = T_world_base @ link_transforms_along(robot, along.at(times), segment.opening)
        parts = [(link.spheres, T) for link, T in zip(robot.links, links, strict=True)]
        if segment.held is not None:
            number, tools = scene.index(segment.held), links[robot.tool_link]
            shape = scene.objects[number].shape
            start = matrix_from_pose(problem.initial.object_poses[number])
            T_tool_object = in_hand.setdefault(segment.held, invert(tools[0]) @ start)
            parts.append((_filled(shape), tools @ T_tool_object))
        for spheres, T in parts:
            yield _moved(spheres, T)


def _moved(spheres: Array, transforms: Array) -> Array:
    """Spheres (k, 4) of a body at every one of its transforms (t, 4, 4): (t k, 4)."""
    centres = np.einsum("tij,kj->tki", transforms[:, :3, :3], spheres[:, :3])
    centres = (centres + transforms[:, None, :3, 3]).reshape(-1, 3)
    return np.column_stack([centres, np.tile(spheres[:, 3], len(transforms))])


def _filled(shape: Shape) -> Array:
    """Spheres (k, 4) all along the surface of the shape, inside; only edges stand out of them."""
    thick = 2.0 * _CELL
    if isinstance(shape, Box):
        inner: Shape = Box(np.maximum(shape.size - thick, 1e-3))
    else:
        radius, height = max(shape.radius - _CELL, 1e-3), max(shape.height - thick, 1e-3)
        inner = Cylinder(radius, height)
    points = np.asarray(shape_mesh(inner).subdivide_to_size(thick).vertices)
    return np.column_stack([points, np.full(len(points), _CELL)])


def _stamp(lowest: Array, origin: Array, spheres: Array) -> None:
    """Lower ``lowest`` (nx, ny) to what spheres (k, 4) reach over each cell, wherever in it."""
    reach = int(np.ceil(spheres[:, 3].max(initial=0.0) / _CELL))
    middle = np.floor((spheres[:, :2] - origin) / _CELL).astype(np.int64)
    near = ((middle >= -reach) & (middle < np.array(lowest.shape) + reach)).all(axis=1)
    middle, spheres = middle[near], spheres[near]
    for offset in np.ndindex(2 * reach + 1, 2 * reach + 1):
        cells = middle + offset - reach
        corner = origin + cells * _CELL
        away = np.clip(spheres[:, :2], corner, corner + _CELL) - spheres[:, :2]
        below = spheres[:, 3] ** 2 - (away**2).sum(axis=1)
        hit = (below > 0.0) & (cells >= 0).all(axis=1) & (cells < lowest.shape).all(axis=1)
        heights = spheres[hit, 2] - np.sqrt(below[hit])
        np.minimum.at(lowest, (cells[hit, 0], cells[hit, 1]), heights)
