"""The cells of KPIECE: which part of a tree to grow next (Sucan and Kavraki, WAFR 2008)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from mamo_core.types.geometry import Array
from mamo_planners.baselines.sampling.growth import Node

WIDER = 4
"""How much wider a cell is than those of the level below."""

GOOD, BAD = 0.9, 0.45
"""What OMPL multiplies a cell's score by after an action that led somewhere new, or did not."""

Coordinate = tuple[int, ...]


@dataclass(eq=False)
class Cell:
    """``coverage``: nodes within. ``neighbours``: cells of its level that share a face with it.

    A cell of the finest level has ``nodes``, any other cells as ``children``.
    """

    coordinate: Coordinate
    score: float
    coverage: int = 0
    selections: int = 1
    neighbours: int = 0
    children: list[Cell] = field(default_factory=list)
    nodes: list[Node] = field(default_factory=list)

    @property
    def importance(self) -> float:
        """The paper's: high where little was done, and where that led on."""
        return self.score / (self.selections * (1 + self.neighbours) * self.coverage)

    @property
    def interior(self) -> bool:
        """Whether there are cells on all sides."""
        return self.neighbours == 2 * len(self.coordinate)


class Cells:
    """Nested levels of cells over 3-D projections; the finest ones are ``size`` (m) wide."""

    def __init__(self, size: float, levels: int, border: float) -> None:
        self._size, self._border = size, border
        self._levels: list[dict[Coordinate, Cell]] = [{} for _ in range(levels)]
        self._iteration = 0

    def add(self, node: Node, projection: Array, distance: float) -> bool:
        """A node at ``projection`` (3,), m, ``distance`` (m) from a goal; whether its cell is new.

        A new cell starts with a score that is higher the later and the nearer to a goal.
        """
        finest = tuple(int(value) for value in np.floor(projection / self._size))
        is_new = False
        parent: Cell | None = None
        for level, cells in enumerate(self._levels):
            width = WIDER ** (len(self._levels) - 1 - level)
            coordinate = tuple(value // width for value in finest)
            cell = cells.get(coordinate)
            is_new = cell is None
            if cell is None:
                score = (1.0 + math.log(self._iteration + 1)) / (1e-3 + distance)
                cell = self._made(cells, coordinate, score)
                if parent is not None:
                    parent.children.append(cell)
            cell.coverage += 1
            parent = cell
        assert parent is not None
        parent.nodes.append(node)
        return is_new

    def select(self, rng: np.random.Generator) -> tuple[list[Cell], Node]:
        """The chain of cells, widest first, and the node to grow from: rather a recent one."""
        self._iteration += 1
        chain = [self._best(self._levels[0].values(), rng)]
        for _ in self._levels[1:]:
            chain.append(self._best(chain[-1].children, rng))
        for cell in chain:
            cell.selections += 1
        nodes = chain[-1].nodes
        back = min(int(abs(rng.normal()) * len(nodes) / 3.0), len(nodes) - 1)
        return chain, nodes[len(nodes) - 1 - back]

    def reward(self, chain: list[Cell], progress: bool) -> None:
        """Lower the scores of cells, less if the action from there made progress."""
        for cell in chain:
            cell.score *= GOOD if progress else BAD

    def _best(self, cells: Iterable[Cell], rng: np.random.Generator) -> Cell:
        inner = [cell for cell in cells if cell.interior]
        outer = [cell for cell in cells if not cell.interior]
        share = max(self._border, len(outer) / (len(inner) + len(outer)))
        chosen = outer if not inner or (outer and rng.random() < share) else inner
        return max(chosen, key=lambda cell: cell.importance)

    def _made(self, cells: dict[Coordinate, Cell], coordinate: Coordinate, score: float) -> Cell:
        cell = Cell(coordinate, score)
        for axis in range(len(coordinate)):
            for step in (-1, 1):
                beside = list(coordinate)
                beside[axis] += step
                other = cells.get(tuple(beside))
                if other is not None:
                    other.neighbours += 1
                    cell.neighbours += 1
        cells[coordinate] = cell
        return cell
