"""CBS and its bounds against an exhaustive search over joint states."""

from __future__ import annotations

import heapq
import itertools
from functools import cache

import numpy as np
import pytest
from mamo_planners.mapf.solvers import cbs, ecbs, prioritized_planning

from mamo_core.types.geometry import Box, Cylinder, Shape, make_pose
from mamo_core.types.mapf import (
    CostField,
    GoalPenalty,
    MAPFAgent,
    MAPFBudget,
    MAPFObstacle,
    MAPFProblem,
    MAPFStatus,
)
from mamo_core.types.region import SweptRegion
from mamo_core.verify_mapf import _bounds, _gap, _goal, _obstacles, _outline, verify_mapf

MOVES = ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1))
BUDGET = MAPFBudget(nodes=1_000, expansions=200_000)
CELL = 0.02
MOST_QUEUED = 60_000


def random_problem(rng: np.random.Generator, agents: int, cells: tuple[int, int]) -> MAPFProblem:
    """Small shapes on a small floor, some too near each other, with all kinds of costs."""
    size = np.array(cells) * CELL
    bodies: list[MAPFAgent] = []
    tries = 0
    while len(bodies) < agents:
        tries += 1
        if tries % 20 == 0:
            bodies = []  # the last ones do not fit
        shape: Shape = Cylinder(0.018, 0.1)
        if rng.random() < 0.6:
            shape = Box(np.array([rng.uniform(0.025, 0.05), rng.uniform(0.025, 0.05), 0.1]))
        xy = rng.uniform(0.025, size - 0.025)
        pose = make_pose([*xy, 0.05], rng.uniform(0.0, 6.28))
        outline = _outline(shape, pose)
        gaps = [_gap(outline, xy, _outline(b.shape, b.pose), b.pose[:2]) for b in bodies]
        if gaps and min(gaps) < -0.004:
            continue
        penalties = tuple(
            GoalPenalty(rng.uniform(0.0, size), 0.03, float(rng.choice([0.5, 1.0, 2.0, np.inf])))
            for _ in range(rng.integers(0, 3))
        )
        field = None
        if rng.random() < 0.3:
            field = CostField(np.zeros(2), 0.04, rng.integers(0, 3, (4, 4)) * 0.5)
        bodies.append(MAPFAgent(f"o{len(bodies)}", shape, pose, penalties, field))
    lowest = np.full((2 * cells[0], 2 * cells[1]), np.inf)
    corner = rng.integers(0, cells, 2)
    lowest[corner[0] : corner[0] + cells[0] // 2, corner[1] : corner[1] + cells[1]] = 0.02
    wall = MAPFObstacle(
        "w", Box(np.array([0.03, 0.02, 0.1])), make_pose([*rng.uniform(0.0, size), 0.05])
    )
    return MAPFProblem(
        agents=tuple(bodies),
        obstacles=(wall,),
        region=SweptRegion(np.zeros(2), CELL / 2.0, lowest, 0.0),
        transit_lower=np.zeros(2),
        transit_upper=size,
        goal_lower=np.array([0.01, 0.0]),
        goal_upper=size,
        resolution=CELL,
        margin=float(rng.choice([0.0, 0.004])),
        goal_margin=float(rng.choice([0.0, 0.003])),
        wait_cost=float(rng.choice([0.25, 1.0])),
    )


def joint_optimum(problem: MAPFProblem) -> float | None:
    """Cheapest joint plan by Dijkstra over positions, who rests and which pairs have parted.

    None: there is none. NaN: too many states to tell.
    """
    agents = problem.agents
    n = len(agents)
    outlines = [_outline(agent.shape, agent.pose) for agent in agents]
    pairs = list(itertools.combinations(range(n), 2))

    def at(i: int, cell: tuple[int, int]) -> np.ndarray:
        return agents[i].pose[:2] + np.array(cell) * problem.resolution

    @cache
    def gap(i: int, j: int, dx: int, dy: int) -> float:
        return _gap(outlines[i], at(i, (dx, dy)), outlines[j], at(j, (0, 0)))

    @cache
    def standable(i: int, cell: tuple[int, int]) -> bool:
        path = np.stack([agents[i].pose[:2], at(i, cell)])
        return not _bounds(problem, agents[i], path) and not _obstacles(problem, agents[i], path)

    @cache
    def rest_cost(i: int, cell: tuple[int, int], moved: bool) -> float:
        """Penalties for resting in the cell; inf if that is no goal."""
        path = np.stack([at(i, (9, 9) if moved else (0, 0)), at(i, cell)])
        if _goal(problem, agents[i], path):
            return float("inf")
        return sum(
            p.cost for p in agents[i].penalties if np.hypot(*(path[1] - p.position)) <= p.radius
        )

    def step_cost(i: int, cell: tuple[int, int]) -> float:
        field = agents[i].cost_field
        if field is None:
            return 1.0
        a, b = np.floor((at(i, cell) - field.origin) / field.resolution).astype(int)
        inside = 0 <= a < field.values.shape[0] and 0 <= b < field.values.shape[1]
        return 1.0 + (float(field.values[a, b]) if inside else 0.0)

    def options(i: int, state: tuple[int, int, bool]) -> list[tuple[float, tuple[int, int, bool]]]:
        x, y, resting = state
        if resting:
            return [(0.0, state)]
        found: list[tuple[float, tuple[int, int, bool]]] = [(problem.wait_cost, (x, y, False))]
        for dx, dy in MOVES[1:]:
            cell = (x + dx, y + dy)
            if standable(i, cell):
                cost = step_cost(i, cell)
                found.append((cost, (*cell, False)))
                if np.isfinite(rest_cost(i, cell, True)):
                    found.append((cost + rest_cost(i, cell, True), (*cell, True)))
        return found

    first_gap = {(i, j): gap(i, j, 0, 0) for i, j in pairs}

    def parting(
        before: tuple, new: tuple[int, int, bool], j: int, now: frozenset, parted: frozenset
    ) -> frozenset | None:
        """Pairs that have parted once j is there too; None if it is too near one before it."""
        for i, other in enumerate(before):
            space = gap(i, j, other[0] - new[0], other[1] - new[1])
            needed = problem.margin if (i, j) in parted else first_gap[i, j]
            if space < min(problem.margin, needed) - 1e-9:
                return None
            if space >= problem.margin - 1e-9:
                now = now | {(i, j)}
        return now

    apart = frozenset(p for p in pairs if first_gap[p] >= problem.margin - 1e-9)
    queue: list[tuple[float, int, tuple, frozenset]] = []
    count = itertools.count()
    starts = []
    for i in range(n):
        start: list[tuple[float, tuple[int, int, bool]]] = [(0.0, (0, 0, False))]
        if np.isfinite(rest_cost(i, (0, 0), False)):
            start.append((rest_cost(i, (0, 0), False), (0, 0, True)))
        starts.append(start)
    for choice in itertools.product(*starts):
        cost = sum(c for c, _ in choice)
        heapq.heappush(queue, (cost, next(count), tuple(s for _, s in choice), apart))
    done: set[tuple] = set()
    while queue:
        cost, _, states, parted = heapq.heappop(queue)
        if (states, parted) in done:
            continue
        done.add((states, parted))
        if all(state[2] for state in states):
            return cost
        if len(queue) > MOST_QUEUED:
            return float("nan")
        partial: list[tuple[float, tuple, frozenset]] = [(cost, (), parted)]
        for j, state in enumerate(states):
            choices = options(j, state)
            partial = [
                (so_far + extra, (*before, new), together)
                for so_far, before, apart_by_now in partial
                for extra, new in choices
                if (together := parting(before, new, j, apart_by_now, parted)) is not None
            ]
        for total, following, now in partial:
            if (following, now) not in done:
                heapq.heappush(queue, (total, next(count), following, now))
    return None


def check(problem: MAPFProblem) -> None:
    optimum = joint_optimum(problem)
    if optimum is not None and np.isnan(optimum):
        pytest.skip("too large for the exhaustive search")
    solution = cbs().solve(problem, BUDGET, np.random.default_rng(0))
    if optimum is None:
        assert solution.status in (MAPFStatus.INFEASIBLE, MAPFStatus.TIMEOUT)
        return
    if solution.status is MAPFStatus.TIMEOUT:
        assert solution.lower_bound <= optimum + 1e-6
        pytest.skip("more work than a test should do")
    assert solution.status is MAPFStatus.OPTIMAL
    assert solution.cost == pytest.approx(optimum, abs=1e-6)
    assert verify_mapf(problem, solution) == []
    for solver in (ecbs(1.5), ecbs(2.0, 2, flexible=False), prioritized_planning(20)):
        other = solver.solve(problem, BUDGET, np.random.default_rng(0))
        assert verify_mapf(problem, other) == []
        assert other.lower_bound <= optimum + 1e-6
        assert other.status is not MAPFStatus.INFEASIBLE
        if other.solved:
            assert other.cost <= other.bound * optimum + 1e-6
        if other.status is MAPFStatus.BOUNDED:
            assert other.bound <= 2.0 + 1e-9


@pytest.mark.parametrize("seed", range(120))
def test_two_agents_cost_the_joint_optimum(seed: int) -> None:
    check(random_problem(np.random.default_rng(seed), 2, (7, 5)))


@pytest.mark.parametrize("seed", range(30))
def test_three_agents_cost_the_joint_optimum(seed: int) -> None:
    check(random_problem(np.random.default_rng(1_000 + seed), 3, (8, 5)))
