"""CBS beside prioritised planning on the MAPF problems that M4M meets (thesis 4.5.3).

    .venv/bin/python benchmarks/mapf_solvers.py --every 3 -o docs/results/mapf.md

M4M plans on the published scenes (MAMO_SCENES); every MAPF problem it poses is solved again by both
solvers, in turn, within the same limits of work, three times each; the fastest time counts.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mamo_planners.mapf.solvers import cbs, prioritized_planning
from measures.common import cpu_seconds

from mamo_core.atomic import atomic_path
from mamo_core.compose import compose
from mamo_core.hookspecs import Component
from mamo_core.interfaces.mapf_solver import MAPFSolver
from mamo_core.plugins import Registered, Registry, discover
from mamo_core.problems.files import read_entries
from mamo_core.problems.published import published_scenes
from mamo_core.recipe_sets import apply_sets
from mamo_core.recipes import find_recipe, load_recipe
from mamo_core.types.mapf import MAPFBudget, MAPFProblem, MAPFSolution

LEVELS = {1: "thesis_5_movables", 2: "thesis_10_movables", 3: "thesis_15_movables"}
LIMITS = MAPFBudget(nodes=2_000, expansions=2_000_000)
PLANNING_SECONDS = 60.0
REPEATS = 3
DRAWS = 2_000


@dataclass(frozen=True)
class Timed:
    """CPU seconds, whether there were paths, and the low-level expansions."""

    seconds: float
    solved: bool
    expansions: int


class Recording(MAPFSolver):
    """Solves with another solver and keeps the problems."""

    def __init__(self, solver: MAPFSolver, met: list[MAPFProblem]) -> None:
        self._solver, self._met = solver, met

    def solve(
        self, problem: MAPFProblem, budget: MAPFBudget, rng: np.random.Generator
    ) -> MAPFSolution:
        self._met.append(problem)
        return self._solver.solve(problem, budget, rng)


def recording(registry: Registry, met: list[MAPFProblem]) -> Registry:
    """The registry with a solver ``recording`` that stands for the portfolio."""
    portfolio = registry.component("mapf", "portfolio")
    component = Component(
        "recording",
        lambda context, options: Recording(portfolio.build(context, options), met),
        portfolio.options,
    )
    item = Registered("mapf", "benchmark", component)
    return Registry((*registry.registered, item), registry.problems, registry.warm_ups)


def problems_met(registry: Registry, scenes: str, every: int) -> Iterator[list[MAPFProblem]]:
    """What M4M asks while it plans on every so many scenes of a set, scene by scene."""
    met: list[MAPFProblem] = []
    recipe = load_recipe(apply_sets(find_recipe("m4m"), ["mapf=recording"]))
    with_recording = recording(registry, met)
    for entry in read_entries(published_scenes(f"{scenes}.jsonl.gz"))[::every]:
        compose(recipe, entry.load()[0], with_recording).solve(PLANNING_SECONDS, seed=0)
        sys.stderr.write(f"{scenes} {entry.id}: {len(met)} problems\n")
        if met:
            yield met.copy()
        met.clear()


def timed(make: Callable[[], MAPFSolver], problem: MAPFProblem) -> Timed:
    """One solution, timed several times."""
    found: list[MAPFSolution] = []
    solver = make()

    def once() -> None:
        found.append(solver.solve(problem, LIMITS, np.random.default_rng(0)))

    seconds = min(cpu_seconds(once) for _ in range(REPEATS))
    return Timed(seconds, found[0].solved, found[0].expansions)


def row(level: int, scenes: list[list[tuple[Timed, Timed]]]) -> str:
    """A line of the table: CBS, then prioritised planning. Every scene counts once in ratios."""
    pairs = [pair for scene in scenes for pair in scene]
    both = [[(a, b) for a, b in scene if a.solved and b.solved] for scene in scenes]
    compared = [scene for scene in both if scene]
    if not compared:
        return f"| {level} | {len(scenes)} | {len(pairs)} |" + " - |" * 6
    ratios = [np.median([a.seconds / b.seconds for a, b in scene]) for scene in compared]
    work = [
        np.median([a.expansions / max(b.expansions, 1) for a, b in scene]) for scene in compared
    ]
    solved = [sum(pair[k].solved for pair in pairs) for k in (0, 1)]
    times = [_milliseconds(pair[k] for scene in compared for pair in scene) for k in (0, 1)]
    return (
        f"| {level} | {len(scenes)} | {len(pairs)} | {solved[0]} | {solved[1]} "
        f"| {_interval(np.array(ratios))} | {np.median(work):.2f} | {times[0]} | {times[1]} |"
    )


def _interval(ratios: np.ndarray) -> str:
    draws = np.random.default_rng(0).choice(ratios, (DRAWS, len(ratios)))
    low, high = np.quantile(np.median(draws, axis=1), [0.025, 0.975])
    return f"{np.median(ratios):.2f} ({low:.2f}-{high:.2f})"


def _milliseconds(times: Iterable[Timed]) -> str:
    values = 1e3 * np.array([t.seconds for t in times])
    return f"{np.median(values):.2f} / {np.quantile(values, 0.95):.1f} / {values.max():.0f}"


HEADER = """| level | scenes | problems | CBS solves | PP solves \
| T_CBS/T_PP, median of scenes (95 %) | expansions, the same \
| CBS ms median / p95 / max of problems | PP ms |
|---|---|---|---|---|---|---|---|---|"""


def main() -> None:
    """Measure and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--every", type=int, default=3, help="every so many scenes of a set")
    parser.add_argument("-o", "--output", type=Path, help="Markdown file (default: stdout)")
    arguments = parser.parse_args()
    registry = discover()
    lines = [HEADER]
    for level, scenes in LEVELS.items():
        met = problems_met(registry, scenes, arguments.every)
        solvers = (cbs, prioritized_planning)
        pairs = [[(timed(solvers[0], p), timed(solvers[1], p)) for p in scene] for scene in met]
        lines.append(row(level, pairs))
    text = "\n".join(lines) + "\n"
    if arguments.output is None:
        sys.stdout.write(text)
        return
    with atomic_path(arguments.output) as work:
        work.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
