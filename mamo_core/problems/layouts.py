"""The workspaces of thesis chapter 3: where they are, and what they are made of.

Their sizes are the thesis' (3.5.1, footnote 6): a table of 0.6 m x 0.8 m, a compartment of 0.6 m x
0.6 m x 0.6 m. It does not say where they are; they stand where its shelf does (chapters 4 to 6), at
the same height, as that is where the right arm of the PR2 works.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mamo_core.types.geometry import Box, make_pose
from mamo_core.types.scene import Fixture, Workspace

_Triple = tuple[float, float, float]


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


_TABLETOP = Layout(
    lower=(0.48, -0.90, 0.77),
    upper=(1.08, -0.10, 1.37),
    boards=(("table", (0.78, -0.50, 0.75), (0.60, 0.80, 0.04)),),
    gap=0.0,
    movables=6,
    immovables=6,
)
_REFRIGERATOR = Layout(
    lower=(0.48, -0.80, 0.77),
    upper=(1.08, -0.20, 1.37),
    boards=(
        ("base", (0.78, -0.50, 0.75), (0.60, 0.60, 0.04)),
        ("back", (1.10, -0.50, 1.07), (0.04, 0.60, 0.68)),
        ("top", (0.78, -0.50, 1.39), (0.60, 0.60, 0.04)),
        ("right", (0.80, -0.82, 1.07), (0.64, 0.04, 0.68)),
        ("left", (0.80, -0.18, 1.07), (0.64, 0.04, 0.68)),
    ),
    gap=0.01,
    movables=3,
    immovables=2,
)

LAYOUTS: dict[str, Layout] = {"tabletop": _TABLETOP, "refrigerator": _REFRIGERATOR}
"""By name: a table (12 objects), and a compartment that is open at -x (5 objects)."""
