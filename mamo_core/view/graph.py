"""The graph of a search over rearrangements, as in Figure 5.3 of the thesis, as SVG.

A miniature for each rearrangement, the initial one at the left, one more action with each column.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap

from mamo_core.types.problem import Problem
from mamo_core.types.search_graph import GraphEdge, SearchGraph
from mamo_core.view.miniature import WIDTH, Miniatures
from mamo_core.view.svg import Style, document, element, label
from mamo_core.view.topdown import ARROW

Words = Callable[[str], str]
"""A cause of failure in words."""

MOST = 60
"""Rearrangements that are drawn: those nearest to the solution."""
_FAILURES = 6
"""Kinds of failures listed below a rearrangement."""
_COLUMN, _LINE, _GAP, _MARGIN, _HEAD = WIDTH + 200.0, 14.0, 18.0, 20.0, 62.0
_NOTE, _NOTE_SIZE, _STUB = 62, 10, 12.0
"""Letters in a line of a note, their size, and the dash before it."""
_GOOD, _PLAIN, _GUESS, _BAD = ARROW, "#8a8f96", "#c9cdd2", "#b3261e"
_HALO: Style = {"paint_order": "stroke", "stroke": "white", "stroke_width": 3.0}
"""Of words that lines may cross."""
_FAILED: Style = {"stroke": _BAD, "stroke_width": 1.0, "stroke_dasharray": "2 2"}


@dataclass(frozen=True)
class _Node:
    """A drawn vertex: the edge that found it, what follows from it, and lines about the rest."""

    number: int
    edge: GraphEdge | None
    children: tuple[_Node, ...]
    notes: tuple[str, ...]


def draw_graph(
    problem: Problem, graphs: Sequence[SearchGraph], words: Words, path: str | Path
) -> None:
    """Write the graph that led to the plan, or else the largest one."""
    graph = chosen(graphs)
    Path(path).write_text(_Picture(problem, graph, words).text(_title(problem, graphs)), "utf-8")


def chosen(graphs: Sequence[SearchGraph]) -> SearchGraph:
    """The last graph with a solution, which is the best one, or else the one with most vertices."""
    solved = [graph for graph in graphs if graph.solution]
    return solved[-1] if solved else max(graphs, key=lambda graph: len(graph.vertices))


def found_by(graph: SearchGraph) -> Mapping[int, GraphEdge]:
    """The edge by which each vertex but the first was found."""
    edges: dict[int, GraphEdge] = {}
    for edge in graph.edges:
        if edge.end and edge.end not in edges:
            edges[edge.end] = edge
    return edges


def shown(graph: SearchGraph, most: int = MOST) -> frozenset[int]:
    """The vertices that are drawn: nearest to the solution first, then the earliest ones."""
    edges = found_by(graph)
    core = set(graph.solution) or {0}
    distance: dict[int, int] = {}
    for number in range(len(graph.vertices)):  # parents come first
        distance[number] = 0 if number in core else distance[edges[number].start] + 1
    nearest = sorted(distance, key=lambda number: (distance[number], number))
    return frozenset(nearest[:most])


class _Picture:
    """Places and writes the nodes of one graph."""

    def __init__(self, problem: Problem, graph: SearchGraph, words: Words) -> None:
        self._graph, self._words = graph, words
        self._small = Miniatures(problem, graph.region)
        self._shown = shown(graph)
        self._found_by = found_by(graph)
        self._parts: list[str] = [self._small.definition]
        self._columns = 1

    def text(self, title: str) -> str:
        root = self._node(0)
        height = _HEAD + self._room(root) + _MARGIN
        self._place(root, 0, _HEAD)
        hidden = len(self._graph.vertices) - len(self._shown)
        left_out = f"; {hidden} of them, the farthest from the solution, are left out"
        self._parts += [
            label(_MARGIN, 26, title + (left_out if hidden else ""), font_size=16),
            *_legend(_MARGIN, 46),
        ]
        width = _MARGIN + (self._columns - 1) * _COLUMN + _COLUMN
        return document(width, height, self._parts)

    def _node(self, number: int) -> _Node:
        own = [edge for edge in self._graph.edges if edge.start == number]
        ends = [e.end for e in own if e.end is not None and self._found_by.get(e.end) is e]
        children = tuple(self._node(end) for end in ends if end in self._shown)
        return _Node(number, self._found_by.get(number), children, self._notes(own))

    def _notes(self, own: Sequence[GraphEdge]) -> tuple[str, ...]:
        """What failed and how often, and what led to rearrangements that were known."""
        counted = Counter(self._note(edge) for edge in own)
        lines = [
            f"{what} x{times}: {why}" if times > 1 else f"{what}: {why}"
            for (what, why), times in counted.most_common()
            if why
        ]
        more = len(lines) - _FAILURES
        return (*lines[:_FAILURES], *([f"and {more} more of these"] if more > 0 else []))

    def _note(self, edge: GraphEdge) -> tuple[str, str]:
        what = f"{edge.kind} {edge.object_name}"
        if edge.end is None:
            return what, self._words(edge.causes[0]) if edge.causes else "nothing to try"
        return what, "" if self._found_by.get(edge.end) is edge else f"leads to #{edge.end}"

    def _own_room(self, node: _Node) -> float:
        """Height of a miniature with the words below it."""
        lines = 1 + sum(len(wrap(note, _NOTE)) for note in node.notes)
        return self._small.height + _LINE * lines + _GAP

    def _room(self, node: _Node) -> float:
        """Height that a node needs with all that follows from it."""
        return max(self._own_room(node), sum(self._room(child) for child in node.children))

    def _place(self, node: _Node, column: int, top: float) -> float:
        """Write a node and all that follows from it; the height of its middle."""
        self._columns = max(self._columns, column + 1)
        x, half = _MARGIN + column * _COLUMN, self._small.height / 2.0
        middles, below = [], top
        for child in node.children:
            middles.append(self._place(child, column + 1, below))
            below += self._room(child)
        wanted = (middles[0] + middles[-1]) / 2.0 if middles else top + half
        own = min(wanted, top + self._room(node) - self._own_room(node) + half)
        for child, middle in zip(node.children, middles, strict=True):
            self._connect(child, x + WIDTH, own, middle)
        self._write(node, x, own)
        self._write_notes(node, x, own + half + 2.0 * _LINE)
        return own

    def _write(self, node: _Node, x: float, middle: float) -> None:
        vertex = self._graph.vertices[node.number]
        before = self._graph.vertices[node.edge.start].poses if node.edge is not None else None
        good = node.number in self._graph.solution
        frame = _GOOD if good else _GUESS if vertex.predicted else _PLAIN
        top = middle - self._small.height / 2.0
        self._parts.append(self._small.draw(x, top, vertex.poses, before, frame))
        words = f"#{node.number}" + (" start" if node.number == 0 else "")
        if good and node.number == self._graph.solution[-1]:
            words += ": the target is taken out"
        elif vertex.predicted:
            words += " believed, not executed"
        self._parts.append(
            label(x, top + self._small.height + 13, words, fill=_GOOD if good else "#555555")
        )

    def _connect(self, child: _Node, right: float, middle: float, end: float) -> None:
        """The action that leads to a child: a curve with its name at the end."""
        assert child.edge is not None, "only the first vertex was found by nothing"
        good = child.number in self._graph.solution
        left = right + _COLUMN - WIDTH
        predicted = self._graph.vertices[child.number].predicted
        self._parts.append(
            element(
                "path",
                d=_curve(right, middle, left, end),
                fill="none",
                stroke=_GOOD if good else _PLAIN,
                stroke_width=3 if good else 1.2,
                stroke_dasharray="5 4" if predicted else None,
            )
        )
        for words, y in ((child.edge.kind, end - 6), (child.edge.object_name, end + 14)):
            style: Style = {"text_anchor": "end", "fill": _GOOD if good else "#333333"}
            self._parts.append(label(left - 6, y, words, **style))

    def _write_notes(self, node: _Node, x: float, y: float) -> None:
        for note in node.notes:
            for line, words in enumerate(wrap(note, _NOTE)):
                if line == 0:
                    self._parts.append(element("path", d=f"M{x:.1f} {y - 3.5:.1f}h9", **_FAILED))
                style: Style = {"font_size": _NOTE_SIZE, "fill": _BAD, **_HALO}
                self._parts.append(label(x + _STUB, y, words, **style))
                y += _LINE


def _curve(x0: float, y0: float, x1: float, y1: float) -> str:
    """From left to right, level at both ends."""
    x = (x0 + x1) / 2.0
    return f"M{x0:.1f} {y0:.1f}C{x:.1f} {y0:.1f} {x:.1f} {y1:.1f} {x1:.1f} {y1:.1f}"


def _title(problem: Problem, graphs: Sequence[SearchGraph]) -> str:
    graph = chosen(graphs)
    place = next(i for i, other in enumerate(graphs, 1) if other is graph)
    which = f" under swept region {place} of {len(graphs)}" if len(graphs) > 1 else ""
    count = len(graph.vertices)
    return f"{problem.name}: {count} rearrangement{'' if count == 1 else 's'}{which}"


def _legend(x: float, y: float) -> Sequence[str]:
    entries = (
        ("on the way to the plan", _GOOD, 3.0, None),
        ("valid", _PLAIN, 1.2, None),
        ("believed, not executed", _PLAIN, 1.2, "5 4"),
        ("failed, and why", _BAD, 1.0, "2 2"),
    )
    parts = []
    for number, (words, color, width, dashes) in enumerate(entries):
        start = x + 185.0 * number
        d = f"M{start:.1f} {y - 4:.1f}h26"
        style: Style = {"stroke": color, "stroke_width": width, "stroke_dasharray": dashes}
        parts += [element("path", d=d, **style), label(start + 32, y, words, fill="#555555")]
    return parts
