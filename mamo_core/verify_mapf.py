"""An independent check of multi-agent paths, with geometry of its own (no lookup tables).

Footprints are compared as planar convex shapes by separating axes and edge distances. A tilted
object counts as solvers must take it: a box as the hull of its projected corners and of its
upright rectangle, a cylinder as the strip of its radius along its projected axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from mamo_core.types.geometry import Array, Box, Cylinder, Shape, matrix_from_pose, yaw_of
from mamo_core.types.mapf import MAPFAgent, MAPFProblem, MAPFSolution, MAPFStatus

TOLERANCE = 1e-6
"""Metres (and lattice steps of cost, relative) within which a rule counts as kept."""
COST_TOLERANCE = 2e-3
"""Relative to the cost, what a claimed cost or bound may be off by (solvers may round costs)."""
TILTED = 1e-4
"""Sine of the tilt above which a body counts as tilted."""


@dataclass(frozen=True, eq=False)
class _Outline:
    """Corners (k, 2) relative to the pose, in order; ``radius`` around them; heights, metres."""

    corners: Array
    radius: float
    bottom: float
    top: float


def verify_mapf(problem: MAPFProblem, solution: MAPFSolution) -> list[str]:
    """What is wrong with a solution, in words; an empty list if nothing is.

    Checked: every agent has a path from its start in unit moves; bounds; obstacles and other
    agents at every time step, with ``margin`` (whatever starts nearer than that must not come
    nearer than it starts: obstacles; is left alone until it has parted: other agents); goals
    outside the region, within the goal bounds and not forbidden; cost, bounds and status.
    """
    if not solution.solved:
        return _unsolved(solution)
    names = [agent.name for agent in problem.agents]
    wrong = [f"{name}: no path" for name in names if name not in solution.paths]
    wrong += [f"{name}: a path of no agent" for name in solution.paths if name not in names]
    if wrong:
        return wrong
    paths = {name: np.asarray(solution.paths[name], dtype=np.float64) for name in names}
    for agent in problem.agents:
        wrong += _lattice(problem, agent, paths[agent.name])
    if wrong:
        return wrong
    for agent in problem.agents:
        wrong += _bounds(problem, agent, paths[agent.name])
        wrong += _obstacles(problem, agent, paths[agent.name])
        wrong += _goal(problem, agent, paths[agent.name])
    wrong += _pairs(problem, paths)
    return wrong + _claims(problem, solution, paths)


def _unsolved(solution: MAPFSolution) -> list[str]:
    if solution.paths:
        return [f"status {solution.status} comes with paths"]
    return []


def _lattice(problem: MAPFProblem, agent: MAPFAgent, path: Array) -> list[str]:
    if path.ndim != 2 or path.shape[1] != 2 or len(path) == 0 or not np.isfinite(path).all():
        return [f"{agent.name}: path of shape {path.shape}, expected (T + 1, 2) finite"]
    wrong = []
    if np.abs(path[0] - agent.pose[:2]).max() > TOLERANCE:
        wrong.append(f"{agent.name}: starts at {path[0]}, stands at {agent.pose[:2]}")
    steps = np.abs(np.diff(path, axis=0))
    for t in range(len(steps)):
        long, short = steps[t].max(), steps[t].min()
        unit = abs(long - problem.resolution) <= TOLERANCE
        if short > TOLERANCE or not (unit or long <= TOLERANCE):
            wrong.append(f"{agent.name}: step {t + 1} goes {steps[t]} m, not one lattice step")
    return wrong


def _bounds(problem: MAPFProblem, agent: MAPFAgent, path: Array) -> list[str]:
    outline = _outline(agent.shape, agent.pose)
    low = outline.corners.min(axis=0) - outline.radius
    high = outline.corners.max(axis=0) + outline.radius
    # Whoever starts beyond a bound may stay as far out as it is.
    lower = np.minimum(problem.transit_lower, path[0] + low) - TOLERANCE
    upper = np.maximum(problem.transit_upper, path[0] + high) + TOLERANCE
    outside = ((path + low < lower) | (path + high > upper)).any(axis=1)
    return [f"{agent.name}: out of bounds at step {t}" for t in np.flatnonzero(outside)[:1]]


def _obstacles(problem: MAPFProblem, agent: MAPFAgent, path: Array) -> list[str]:
    outline = _outline(agent.shape, agent.pose)
    wrong = []
    for obstacle in problem.obstacles:
        other = _outline(obstacle.shape, obstacle.pose)
        if not _same_height(outline, other):
            continue
        gaps = [_gap(outline, xy, other, obstacle.pose[:2]) for xy in path]
        least = min(problem.margin, gaps[0]) - TOLERANCE
        near = [t for t, gap in enumerate(gaps) if gap < least]
        if near:
            wrong.append(
                f"{agent.name}: {gaps[near[0]]:.4f} m from {obstacle.name} at step {near[0]}"
            )
    return wrong


def _goal(problem: MAPFProblem, agent: MAPFAgent, path: Array) -> list[str]:
    wrong = []
    stays = bool((np.abs(path - path[0]) <= TOLERANCE).all())
    pose = np.concatenate([path[-1], agent.pose[2:]])
    shape = agent.shape if stays else _wider(agent.shape, problem.goal_margin)
    if problem.region.overlaps(shape, pose):
        wrong.append(f"{agent.name}: ends inside the region")
    for penalty in agent.penalties:
        near = np.hypot(*(path[-1] - penalty.position)) <= penalty.radius - TOLERANCE
        if near and np.isinf(penalty.cost):
            wrong.append(f"{agent.name}: ends at a forbidden place, {penalty.position}")
    outline = _outline(agent.shape, agent.pose)
    low = outline.corners.min(axis=0) - outline.radius + path[-1]
    high = outline.corners.max(axis=0) + outline.radius + path[-1]
    out = (low < problem.goal_lower - TOLERANCE) | (high > problem.goal_upper + TOLERANCE)
    if out.any() and not stays:
        wrong.append(f"{agent.name}: ends out of the goal bounds")
    return wrong


def _pairs(problem: MAPFProblem, paths: dict[str, Array]) -> list[str]:
    outlines = [_outline(agent.shape, agent.pose) for agent in problem.agents]
    wrong = []
    for j, second in enumerate(problem.agents):
        for i, first in enumerate(problem.agents[:j]):
            if _same_height(outlines[i], outlines[j]):
                t = _collision(
                    problem, outlines[i], paths[first.name], outlines[j], paths[second.name]
                )
                if t is not None:
                    wrong.append(f"{first.name} and {second.name}: too close at step {t}")
    return wrong


def _collision(
    problem: MAPFProblem, first: _Outline, path: Array, second: _Outline, other: Array
) -> int | None:
    """First step at which a pair is too close, from when it is first apart."""
    apart = False
    for t in range(max(len(path), len(other))):
        a, b = path[min(t, len(path) - 1)], other[min(t, len(other) - 1)]
        gap = _gap(first, a, second, b)
        if apart and gap < problem.margin - TOLERANCE:
            return t
        # At the margin itself, rounding decides whether a pair has parted: be lenient.
        apart = apart or gap >= problem.margin + (TOLERANCE if t > 0 else -TOLERANCE)
    return None


def _claims(problem: MAPFProblem, solution: MAPFSolution, paths: dict[str, Array]) -> list[str]:
    cost = sum(path_cost(problem, agent, paths[agent.name]) for agent in problem.agents)
    slack = COST_TOLERANCE * max(1.0, cost)
    wrong = []
    if not abs(cost - solution.cost) <= slack:
        wrong.append(f"cost {solution.cost} claimed, {cost} paid")
    if solution.lower_bound > cost + slack:
        wrong.append(f"lower bound {solution.lower_bound} above the cost {cost}")
    if solution.bound < 1.0 or cost > solution.bound * solution.lower_bound + slack:
        wrong.append(f"bound {solution.bound} does not follow from {solution.lower_bound}")
    if solution.status is MAPFStatus.OPTIMAL and solution.bound != 1.0:
        wrong.append(f"status optimal with bound {solution.bound}")
    if solution.status is MAPFStatus.BOUNDED and not np.isfinite(solution.bound):
        wrong.append("status bounded without a bound")
    return wrong


def path_cost(problem: MAPFProblem, agent: MAPFAgent, path: Array) -> float:
    """Cost of a path (T + 1, 2) m in lattice steps, from the rules of ``MAPFProblem``."""
    last = len(path) - 1
    while last > 0 and np.abs(path[last] - path[last - 1]).max() <= TOLERANCE:
        last -= 1
    total = 0.0
    for t in range(1, last + 1):
        if np.abs(path[t] - path[t - 1]).max() <= TOLERANCE:
            total += problem.wait_cost
        else:
            total += 1.0 + _field_cost(agent, path[t])
    for penalty in agent.penalties:
        if np.hypot(*(path[-1] - penalty.position)) <= penalty.radius + 1e-9:
            total += penalty.cost
    return total


def _field_cost(agent: MAPFAgent, xy: Array) -> float:
    field = agent.cost_field
    if field is None:
        return 0.0
    i, j = np.floor((xy - field.origin) / field.resolution + 1e-9).astype(int)
    nx, ny = field.values.shape
    return float(field.values[i, j]) if 0 <= i < nx and 0 <= j < ny else 0.0


def _wider(shape: Shape, amount: float) -> Shape:
    if isinstance(shape, Box):
        return Box(shape.size + np.array([2.0 * amount, 2.0 * amount, 0.0]))
    return Cylinder(shape.radius + amount, shape.height)


def _outline(shape: Shape, pose: Array) -> _Outline:
    T = matrix_from_pose(pose)
    axis = T[:3, 2]
    lean = float(np.hypot(axis[0], axis[1]))
    half, z = shape.height / 2.0, float(pose[2])
    if isinstance(shape, Cylinder):
        if lean <= TILTED:
            return _Outline(np.zeros((1, 2)), shape.radius, z - half, z + half)
        reach = max(half, half * abs(axis[2]) + shape.radius * lean)
        ends = np.stack([half * axis[:2], -half * axis[:2]])
        return _Outline(ends, shape.radius, z - reach, z + reach)
    hx, hy = shape.size[:2] / 2.0
    yaw = yaw_of(pose)
    u, v = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
    corners = np.stack([hx * u + hy * v, -hx * u + hy * v, -hx * u - hy * v, hx * u - hy * v])
    if lean <= TILTED:
        return _Outline(corners, 0.0, z - half, z + half)
    cube = np.stack(np.meshgrid(*([[-0.5, 0.5]] * 3)), axis=-1).reshape(-1, 3) * shape.size
    turned = cube @ T[:3, :3].T
    points = np.concatenate([corners, turned[:, :2]])
    reach = max(half, float(turned[:, 2].max()))
    return _Outline(points[ConvexHull(points).vertices], 0.0, z - reach, z + reach)


def _same_height(first: _Outline, second: _Outline) -> bool:
    return min(first.top, second.top) - max(first.bottom, second.bottom) > TOLERANCE


def _gap(first: _Outline, at: Array, second: _Outline, there: Array) -> float:
    """Distance (m) between two outlines; negative: how far one must move for them to touch."""
    a, b = first.corners + at, second.corners + there
    radius = first.radius + second.radius
    separation = max(_least_separation(a, b), _least_separation(b, a))
    # Apart, or without depth (points and parallel lines): edges tell the distance.
    if separation > 0.0 or _flat(a, b):
        return _edge_distance(a, b) - radius
    return separation - radius


def _flat(a: Array, b: Array) -> bool:
    """Whether the shapes can only touch: points, a point and a line, parallel lines."""
    if len(a) > 2 or len(b) > 2:
        return False
    along, other = a[-1] - a[0], b[-1] - b[0]
    return bool(abs(along[0] * other[1] - along[1] * other[0]) < 1e-15)


def _least_separation(a: Array, b: Array) -> float:
    """Largest gap between the shapes along the outward normals of ``a`` (k, 2)."""
    if len(a) == 1:
        return -np.inf
    edges = np.roll(a, -1, axis=0) - a
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return float(((b @ normals.T).min(axis=0) - np.einsum("ij,ij->i", a, normals)).max())


def _edge_distance(a: Array, b: Array) -> float:
    return min(_corner_distance(a, b), _corner_distance(b, a))


def _corner_distance(corners: Array, polygon: Array) -> float:
    """Least distance from corners (k, 2) to the edges of a polygon (m, 2)."""
    start = polygon
    edge = np.roll(polygon, -1, axis=0) - start
    length = np.maximum((edge**2).sum(axis=1), 1e-30)
    offset = corners[:, None, :] - start
    along = np.clip((offset * edge).sum(axis=2) / length, 0.0, 1.0)
    return float(np.linalg.norm(offset - along[..., None] * edge, axis=2).min())
