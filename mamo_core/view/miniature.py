"""A rearrangement from above, small, as SVG: the robot stands below, y to the left."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from mamo_core.types.geometry import Array, Cylinder, footprint_corners
from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility, SceneObject
from mamo_core.view.svg import Style, element, text_of
from mamo_core.view.topdown import ARROW, COLORS, EDGE, REGION

WIDTH = 150.0
"""Pixels across the workspace."""
_FRONT = 0.06
"""Shown before the open side, m."""
_STAGE = "stage"
_SHOWN_MOVE = 0.01


class Miniatures:
    """Draws states of one problem; what is the same in all of them is written once."""

    def __init__(self, problem: Problem, region: SweptRegion | None) -> None:
        space = problem.scene.workspace
        self._problem, self._region = problem, region
        self._upper = space.upper[:2]
        self._lower = space.lower[:2] - np.array([_FRONT, 0.0])
        self._scale = WIDTH / float(self._upper[1] - self._lower[1])
        self.height = self._scale * float(self._upper[0] - self._lower[0])

    @cached_property
    def definition(self) -> str:
        """What every miniature refers to: the floor, and what the retrieval sweeps."""
        floor = element("rect", width=WIDTH, height=self.height, fill="#fbfaf7")
        front = self.height - _FRONT * self._scale
        edge = element("path", d=f"M0 {front:.1f}H{WIDTH:.1f}", stroke="#c9b291", stroke_width=1)
        return element("defs", element("g", floor, self._swept(), edge, id=_STAGE))

    def draw(self, x: float, y: float, poses: Array, before: Array | None, frame: str) -> str:
        """The state with its upper left corner at (x, y); what moved since ``before`` (n, 7) is
        drawn with its way. ``frame``: colour of the border."""
        items = list(zip(self._problem.scene.objects, poses, strict=True))
        moves = [] if before is None else self._moves(before, poses)
        return element(
            "g",
            element("use", href=f"#{_STAGE}"),
            *(self._object(item, pose) for item, pose in items),
            *moves,
            element(
                "rect", width=WIDTH, height=self.height, fill="none", stroke=frame, stroke_width=2
            ),
            transform=f"translate({x:.1f} {y:.1f})",
        )

    def _seen(self, points: Array) -> Array:
        """World x, y (k, 2) in pixels."""
        return (self._upper - points)[:, ::-1] * self._scale

    def _swept(self) -> str:
        """The cells of the region, a rectangle for each run of them in a row."""
        if self._region is None:
            return ""
        region, parts = self._region, []
        swept = region.swept_under(float(self._problem.scene.workspace.upper[2]))
        for row, cells in enumerate(swept):
            edges = np.flatnonzero(np.diff(np.concatenate([[0], cells, [0]])))
            for first, last in zip(edges[::2], edges[1::2], strict=True):
                corners = np.array([[row, first], [row + 1, last]]) * region.resolution
                inside = np.clip(region.origin + corners, self._lower, self._upper)
                (right, bottom), (left, top) = self._seen(inside)
                parts.append(f"M{left:.1f} {top:.1f}H{right:.1f}V{bottom:.1f}H{left:.1f}Z")
        return element("path", d="".join(parts), fill=REGION)

    def _object(self, item: SceneObject, pose: Array) -> str:
        style: Style = {"fill": COLORS[item.mobility], "stroke": EDGE, "stroke_width": 0.6}
        name = element("title", text_of(item.name))
        if isinstance(item.shape, Cylinder):
            x, y = self._seen(pose[None, :2])[0]
            radius = item.shape.radius * self._scale
            return element("circle", name, cx=x, cy=y, r=radius, **style)
        corners = self._seen(footprint_corners(item.shape, pose))
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in corners)
        return element("polygon", name, points=points, **style)

    def _moves(self, before: Array, after: Array) -> Sequence[str]:
        moved = np.linalg.norm(after[:, :2] - before[:, :2], axis=1) > _SHOWN_MOVE
        lines = []
        for place in np.flatnonzero(moved):
            if self._problem.scene.objects[place].mobility is Mobility.IMMOVABLE:
                continue
            (x0, y0), (x1, y1) = self._seen(np.array([before[place, :2], after[place, :2]]))
            d = f"M{x0:.1f} {y0:.1f}L{x1:.1f} {y1:.1f}"
            lines.append(element("path", d=d, stroke=ARROW, stroke_width=1.6))
            lines.append(element("circle", cx=x1, cy=y1, r=2.2, fill=ARROW))
        return lines
