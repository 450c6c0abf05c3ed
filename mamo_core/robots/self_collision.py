"""The robot against itself, on exact meshes: arm against body, arm against arm, what is held."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mamo_core.interfaces.collision_checker import HeldObject
from mamo_core.robots.fcl_shapes import half_size, mesh_tree, placed_at, solid
from mamo_core.robots.kinematics import link_transforms_along, tool_transform
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import sampled
from mamo_core.types.geometry import (
    Array,
    BoolArray,
    IntArray,
    invert,
    matrix_from_pose,
)
from mamo_core.types.motion import MotionSegment
from mamo_core.types.scene import Scene, SceneState

_STEP = 0.02
"""Segments are looked at this often at least, rad of the fastest joint."""


@dataclass(frozen=True, eq=False)
class _Piece:
    """A surface of part ``number`` (the held object has -1) in its frame, and a ball around it.

    ``link``: the link that carries it, -1 for the base.
    """

    number: int
    link: int
    geometry: Any
    centre: Array
    radius: float
    T_link_piece: Array


class SelfCollisions:
    """Where an arm collides with itself, the robot's body, or what it holds with either.

    Pairs are ``ArmModel.self_pairs``; what is held may touch nothing but the hand.
    """

    def __init__(self, arm: ArmModel, held: HeldObject | None = None) -> None:
        self._arm = arm
        links = len(arm.links)
        names = [*arm.part_names]
        pieces = [
            _Piece(number, number if number < links else -1, *_ball(path), np.eye(4))
            for number, part in enumerate(arm.parts)
            for path in part.meshes
        ]
        pairs = set(arm.self_pairs)
        if held is not None:
            pieces.append(_held(arm, held))
            names.append(held.name)
            hand = arm.links[arm.tool_link].coordinate
            pairs |= {
                (-1, n) for n in range(len(arm.links) + len(arm.body)) if not _of_hand(arm, n, hand)
            }
        self._names, self._pieces = names, pieces
        rows = [
            (a, b)
            for a, one in enumerate(pieces)
            for b, other in enumerate(pieces)
            if (one.number, other.number) in pairs
        ]
        self._pairs = np.array(rows, dtype=np.int64).reshape(-1, 2)

    def free(self, configurations: Array, opening: float) -> BoolArray:
        """Which configurations (k, dof) are without; ``opening`` of the gripper, m."""
        rows = np.atleast_2d(configurations)
        touched = {row for row, _ in self._touching(rows, opening)}
        return np.array([row not in touched for row in range(len(rows))])

    def first(self, configurations: Array, opening: float) -> tuple[str, str] | None:
        """Names of two parts that collide at one of configurations (k, dof)."""
        found = self._touching(np.atleast_2d(configurations), opening)
        return next((names for _, names in found), None)

    def _touching(
        self, configurations: Array, opening: float
    ) -> Iterator[tuple[int, tuple[str, str]]]:
        """Numbers of configurations with a collision, and its parts; the first of each."""
        import fcl

        frames = link_transforms_along(self._arm, configurations, opening)
        base = np.tile(np.eye(4), (len(configurations), 1, 1))
        placed = [
            (frames[piece.link] if piece.link >= 0 else base) @ piece.T_link_piece
            for piece in self._pieces
        ]
        done = -1
        for row, pair in self._near(placed).tolist():
            if row == done:
                continue
            a, b = self._pairs[pair]
            one, other = (
                fcl.CollisionObject(self._pieces[n].geometry, placed_at(fcl, placed[n][row]))
                for n in (a, b)
            )
            if fcl.collide(one, other):
                done = row
                yield row, tuple(self._names[self._pieces[n].number] for n in (a, b))

    def _near(self, placed: Sequence[Array]) -> IntArray:
        """Numbers (n, 2), ascending, of configurations and pairs whose balls meet."""
        centres = np.array(
            [
                T[:, :3, :3] @ p.centre + T[:, :3, 3]
                for T, p in zip(placed, self._pieces, strict=True)
            ]
        )
        radii = np.array([piece.radius for piece in self._pieces])
        a, b = self._pairs.T
        ways = centres[a] - centres[b]
        squares = np.einsum("nki,nki->nk", ways, ways)
        return np.argwhere((squares <= ((radii[a] + radii[b]) ** 2)[:, None]).T)


def _of_hand(arm: ArmModel, number: int, hand: int) -> bool:
    """Whether a part is the hand or a finger."""
    return number < len(arm.links) and arm.links[number].coordinate in (hand, -1)


def _held(arm: ArmModel, held: HeldObject) -> _Piece:
    radius = float(np.linalg.norm(half_size(held.shape)))
    T = arm.T_link_tool @ held.T_tool_object
    return _Piece(-1, arm.tool_link, solid(held.shape), np.zeros(3), radius, T)


def _ball(path: Path) -> tuple[Any, Array, float]:
    """The mesh as a tree, and the ball around its box."""
    tree, centre, half = mesh_tree(path)
    return tree, centre, float(np.linalg.norm(half))


def check_self_collisions(
    scene: Scene,
    segments: Sequence[MotionSegment],
    states: Sequence[SceneState],
    robot: ArmModel,
    opening: float,
) -> list[str]:
    """Where the robot collides with itself, or with what it holds, in words; empty if nowhere.

    All segments are looked at, in contact or not. ``states``: one for the start of each segment;
    ``opening`` (m): the gripper's before the first segment.
    """
    failures = []
    before, held, bare = opening, None, SelfCollisions(robot)
    for segment, state in zip(segments, states, strict=True):
        held = _in_hand(scene, segment, state, robot, held)
        check = bare if held is None else SelfCollisions(robot, held)
        rows = sampled(segment.trajectory, _STEP)
        # The fingers move during a segment: both ends of their way are checked.
        for width in {before, segment.opening}:
            names = check.first(rows, width)
            if names is not None:
                failures.append(f"{segment.kind}: {names[0]} collides with {names[1]}")
                break
        before = segment.opening
    return failures


def _in_hand(
    scene: Scene,
    segment: MotionSegment,
    state: SceneState,
    robot: ArmModel,
    before: HeldObject | None,
) -> HeldObject | None:
    """What a segment holds, where the hand took it."""
    if segment.held is None or (before is not None and before.name == segment.held):
        return before if segment.held is not None else None
    place = scene.index(segment.held)
    T_base_tool = tool_transform(robot, segment.trajectory.positions[0])
    T_world_tool = matrix_from_pose(scene.T_world_base) @ T_base_tool
    T = invert(T_world_tool) @ matrix_from_pose(state.object_poses[place])
    return HeldObject(segment.held, scene.objects[place].shape, T)
