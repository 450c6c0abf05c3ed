"""Simple motion primitives: one joint moves by one step (thesis 3.3.1)."""

from __future__ import annotations

import numpy as np

from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, IntArray

Cell = tuple[int, ...]
"""A configuration of the lattice: steps of each joint from the start."""

_LARGE_JOINTS = 4


class Lattice:
    """Configurations that lie whole steps away from ``start`` (dof,), within joint limits."""

    def __init__(self, arm: ArmModel, start: Array, large_deg: float, small_deg: float) -> None:
        steps = np.full(arm.dof, np.radians(small_deg))
        steps[:_LARGE_JOINTS] = np.radians(large_deg)
        self.steps = steps
        self._start = np.array(start)
        lower, upper = arm.around_home
        self._least = np.minimum(np.ceil((lower - self._start) / steps), 0.0).astype(np.int64)
        self._most = np.maximum(np.floor((upper - self._start) / steps), 0.0).astype(np.int64)
        eye = np.eye(arm.dof, dtype=np.int64)
        self._moves: IntArray = np.vstack([eye, -eye])

    @property
    def start(self) -> Cell:
        """Where no joint has moved."""
        return (0,) * len(self._start)

    def configuration(self, cell: Cell) -> Array:
        """Joint positions (dof,) of a cell."""
        return self._start + self.steps * np.array(cell)

    def nearest(self, q: Array) -> Cell:
        """The cell closest to a configuration (dof,)."""
        counts = np.rint((q - self._start) / self.steps).astype(np.int64)
        return tuple(np.clip(counts, self._least, self._most).tolist())

    def successors(self, cell: Cell) -> list[Cell]:
        """Cells one primitive away."""
        cells = np.array(cell) + self._moves
        inside = ((cells >= self._least) & (cells <= self._most)).all(axis=1)
        return [tuple(row) for row in cells[inside].tolist()]
