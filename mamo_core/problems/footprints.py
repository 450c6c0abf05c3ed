"""Upright shapes seen from above: how far apart or how deep in each other, and which way."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from mamo_core.types.geometry import Box, Shape

_Vector = tuple[float, float]


class Footprint(NamedTuple):
    """A disc (``hx`` = ``hy`` = 0) or a rectangle turned by the angle of cosine c and sine s.

    ``x``, ``y``: centre, m. ``radius``: of the disc, or of the circle around the rectangle, m.
    Plain floats: the fake world compares thousands of pairs, where arrays would be slow.
    """

    x: float
    y: float
    c: float
    s: float
    hx: float
    hy: float
    radius: float

    @property
    def round(self) -> bool:
        """Whether this is a disc."""
        return self.hx == 0.0


class Separation(NamedTuple):
    """``distance`` in metres, negative inside; (``nx``, ``ny``): unit vector to the second one."""

    distance: float
    nx: float
    ny: float

    def flipped(self) -> Separation:
        """The same seen from the second footprint."""
        return Separation(self.distance, -self.nx, -self.ny)


def footprint(shape: Shape, pose: npt.ArrayLike) -> Footprint:
    """The footprint of an upright shape at a pose (7,), world."""
    px, py, _, w, x, y, z = np.asarray(pose, dtype=np.float64).tolist()
    if not isinstance(shape, Box):
        return disc(px, py, shape.radius)
    yaw = math.atan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))
    return rectangle(px, py, yaw, shape.size[0] / 2.0, shape.size[1] / 2.0)


def disc(x: float, y: float, radius: float) -> Footprint:
    """A disc, metres."""
    return Footprint(x, y, 1.0, 0.0, 0.0, 0.0, radius)


def rectangle(x: float, y: float, yaw: float, hx: float, hy: float) -> Footprint:
    """A rectangle of half extents ``hx``, ``hy`` (m) turned by ``yaw`` (rad)."""
    hx, hy = float(hx), float(hy)
    return Footprint(x, y, math.cos(yaw), math.sin(yaw), hx, hy, math.hypot(hx, hy))


def separation(a: Footprint, b: Footprint) -> Separation:
    """Exact distance of two footprints, or minus the depth of the smallest way out."""
    if a.round and b.round:
        return _discs(a, b)
    if a.round:
        return _box_disc(b, a).flipped()
    if b.round:
        return _box_disc(a, b)
    return _boxes(a, b)


def _discs(a: Footprint, b: Footprint) -> Separation:
    dx, dy = b.x - a.x, b.y - a.y
    distance = math.hypot(dx, dy)
    if distance == 0.0:
        return Separation(-a.radius - b.radius, 1.0, 0.0)
    return Separation(distance - a.radius - b.radius, dx / distance, dy / distance)


def _box_disc(box: Footprint, other: Footprint) -> Separation:
    u, v = _local(box, other.x, other.y)
    du, dv = abs(u) - box.hx, abs(v) - box.hy
    if du <= 0.0 and dv <= 0.0:
        # The centre is inside: out through the nearest side.
        along_u = du >= dv
        nu, nv = (_sign(u), 0.0) if along_u else (0.0, _sign(v))
        return _in_world(box, max(du, dv) - other.radius, nu, nv)
    gu, gv = math.copysign(max(du, 0.0), u), math.copysign(max(dv, 0.0), v)
    distance = math.hypot(gu, gv)
    return _in_world(box, distance - other.radius, gu / distance, gv / distance)


def _boxes(a: Footprint, b: Footprint) -> Separation:
    best = Separation(-math.inf, 1.0, 0.0)
    dx, dy = b.x - a.x, b.y - a.y
    for ax, ay in ((a.c, a.s), (-a.s, a.c), (b.c, b.s), (-b.s, b.c)):
        along = dx * ax + dy * ay
        gap = abs(along) - _reach(a, ax, ay) - _reach(b, ax, ay)
        if gap > best.distance:
            sign = _sign(along)
            best = Separation(gap, sign * ax, sign * ay)
    if best.distance <= 0.0:
        return best
    # Apart: the shortest way starts or ends at a corner.
    ways = [_box_disc(a, disc(x, y, 0.0)) for x, y in _corners(b)]
    ways += [_box_disc(b, disc(x, y, 0.0)).flipped() for x, y in _corners(a)]
    return min(ways)


def _local(box: Footprint, x: float, y: float) -> _Vector:
    dx, dy = x - box.x, y - box.y
    return box.c * dx + box.s * dy, -box.s * dx + box.c * dy


def _in_world(box: Footprint, distance: float, u: float, v: float) -> Separation:
    return Separation(distance, box.c * u - box.s * v, box.s * u + box.c * v)


def _reach(box: Footprint, ax: float, ay: float) -> float:
    """Half extent of a rectangle along a unit vector."""
    along_u = abs(box.c * ax + box.s * ay)
    along_v = abs(-box.s * ax + box.c * ay)
    return box.hx * along_u + box.hy * along_v


def _corners(box: Footprint) -> list[_Vector]:
    return [
        (box.x + box.c * u - box.s * v, box.y + box.s * u + box.c * v)
        for u in (box.hx, -box.hx)
        for v in (box.hy, -box.hy)
    ]


def extents(one: Footprint) -> tuple[float, float, float, float]:
    """Lower x, lower y, upper x, upper y of a footprint, metres."""
    if one.round:
        ex = ey = one.radius
    else:
        ex, ey = _reach(one, 1.0, 0.0), _reach(one, 0.0, 1.0)
    return one.x - ex, one.y - ey, one.x + ex, one.y + ey


def apart(a: Footprint, b: Footprint, gap: float) -> bool:
    """Whether two footprints are at least ``gap`` (m) apart."""
    if math.hypot(a.x - b.x, a.y - b.y) >= a.radius + b.radius + gap:
        return True
    return separation(a, b).distance >= gap


def _sign(value: float) -> float:
    return math.copysign(1.0, value)
