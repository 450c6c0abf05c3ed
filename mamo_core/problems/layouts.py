"""The workspaces of thesis chapter 3: where they are, and what they are made of.

Both stand where the thesis' shelf does (chapters 4 to 6), at the same height: that is where the
right arm of the PR2 works. The thesis tells neither sizes nor places; 0.6 m x 0.8 m is the floor
of that shelf.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mamo_core.problems.importers import INTERIOR_LOWER, INTERIOR_UPPER
from mamo_core.types.geometry import Box, make_pose
from mamo_core.types.scene import Fixture, Workspace

_Triple = tuple[float, float, float]

BOARD = 0.04
"""Thickness of table top and walls, m."""


@dataclass(frozen=True)
class Layout:
    """A workspace and how many objects the thesis puts there.

    ``lower``, ``upper``: corners of the box the objects belong in, m, world. ``boards``: name,
    centre and full extents (m, world) of each fixture. ``gap``: distance (m) that footprints keep
    from the sides of the box. ``immovables`` include the target.
    """

    lower: _Triple
    upper: _Triple
    boards: tuple[tuple[str, _Triple, _Triple], ...]
    gap: float
    movables: int
    immovables: int

    def workspace(self) -> Workspace:
        """The box; no object stands over its front edge."""
        return Workspace(np.array(self.lower), np.array(self.upper), overhang=0.0)

    def fixtures(self) -> tuple[Fixture, ...]:
        """The boards, of friction 1: a pair has the coefficient of the object."""
        return tuple(
            Fixture(name, Box(np.array(size)), make_pose(center))
            for name, center, size in self.boards
        )


def _tabletop() -> Layout:
    (x0, y0, z), (x1, y1, _) = INTERIOR_LOWER, INTERIOR_UPPER
    center = ((x0 + x1) / 2.0, (y0 + y1) / 2.0, z - BOARD / 2.0)
    table = ("table", center, (x1 - x0, y1 - y0, BOARD))
    return Layout((x0, y0, z), (x1, y1, z + 0.6), (table,), gap=0.0, movables=6, immovables=6)


def _refrigerator() -> Layout:
    x0, y0, z0 = INTERIOR_LOWER[0], -0.80, INTERIOR_LOWER[2]
    x1, y1, z1 = x0 + 0.6, y0 + 0.6, z0 + 0.6
    x, y, z, half = x0 + 0.3, y0 + 0.3, z0 + 0.3, BOARD / 2.0
    boards = (
        ("base", (x, y, z0 - half), (0.6, 0.6, BOARD)),
        ("back", (x1 + half, y, z), (BOARD, 0.6, 0.6 + 2 * BOARD)),
        ("top", (x, y, z1 + half), (0.6, 0.6, BOARD)),
        ("right", (x + half, y0 - half, z), (0.6 + BOARD, BOARD, 0.6 + 2 * BOARD)),
        ("left", (x + half, y1 + half, z), (0.6 + BOARD, BOARD, 0.6 + 2 * BOARD)),
    )
    return Layout((x0, y0, z0), (x1, y1, z1), boards, gap=0.01, movables=3, immovables=2)


LAYOUTS: dict[str, Layout] = {"tabletop": _tabletop(), "refrigerator": _refrigerator()}
"""By name: a table (12 objects), and a compartment that is open at -x (5 objects)."""
