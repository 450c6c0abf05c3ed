"""Neighbours but one: whether they collide hangs on two joints, so it is written down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from mamo_core.types.geometry import Array

if TYPE_CHECKING:
    from mamo_core.robots.model import ArmModel

_CELL = 0.025
"""Side of a cell at most, rad."""


@dataclass(frozen=True, eq=False)
class PairTable:
    """Where a link may touch the one before its predecessor.

    ``joints``: the two between them; ``low``, ``cell`` (2,): their lowest positions, and the sides
    of a cell, rad. ``blocked`` (m, n): no configuration of the other cells is a collision of the
    meshes.
    """

    joints: tuple[int, int]
    low: Array
    cell: Array
    blocked: npt.NDArray[np.bool_]


def measure_table(arm: ArmModel, one: int, other: int, solids: Sequence[Any]) -> PairTable:
    """The table of link ``one`` and link ``other``; ``solids``: as in ``measure_pairs``."""
    from mamo_core.robots.kinematics import joint_transform
    from mamo_core.robots.self_pairs import Geometry

    middle, last = arm.links[arm.links[one].parent], arm.links[one]
    joints = middle.coordinate, last.coordinate
    low, high = arm.lower[list(joints)], arm.upper[list(joints)]
    counts = np.ceil((high - low) / _CELL).astype(int)
    cell = (high - low) / counts
    a, b = Geometry(solids[one]), Geometry(solids[other])
    slack = _travel(arm, one, solids[one]) @ (cell / 2.0)
    blocked = np.zeros(tuple(counts), dtype=np.bool_)
    second = [
        last.T_parent_joint @ joint_transform(last, low[1] + (n + 0.5) * cell[1])
        for n in range(counts[1])
    ]
    for m in range(counts[0]):
        turned = joint_transform(middle, low[0] + (m + 0.5) * cell[0])
        first = middle.T_parent_joint @ turned
        for n in range(counts[1]):
            blocked[m, n] = a.distance(b, first @ second[n]) <= slack
    return PairTable(joints, low, cell, blocked)


def _travel(arm: ArmModel, one: int, solid: Any) -> Array:
    """How far (2,) a turn of either joint by a radian moves a point of the link at most, m."""
    link = arm.links[one]
    corners = np.vstack([mesh.vertices for mesh in solid.meshes])
    reach = float(np.linalg.norm(corners, axis=1).max())
    return np.array([reach + float(np.linalg.norm(link.T_parent_joint[:3, 3])), reach])


def write_tables(tables: Sequence[PairTable], path: Path) -> None:
    """Write them into one file (NPZ)."""
    arrays: dict[str, Any] = {}
    for k, table in enumerate(tables):
        arrays[f"{k}.joints"] = np.array(table.joints)
        arrays[f"{k}.grid"] = np.array([table.low, table.cell])
        arrays[f"{k}.blocked"] = table.blocked
    np.savez(path, count=np.array(len(tables)), **arrays)


def read_tables(path: Path) -> tuple[PairTable, ...]:
    """What ``write_tables`` has written."""
    tables = []
    with np.load(path) as file:
        for k in range(int(file["count"])):
            one, other = file[f"{k}.joints"].tolist()
            grid, blocked = file[f"{k}.grid"], file[f"{k}.blocked"]
            for array in (grid, blocked):
                array.flags.writeable = False
            tables.append(PairTable((one, other), grid[0], grid[1], blocked))
    return tuple(tables)
