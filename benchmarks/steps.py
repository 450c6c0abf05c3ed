"""MuJoCo's steps one by one, as the default of the interface has it, and in compiled stretches.

    python benchmarks/steps.py

The same pushes on a shelf with 15 objects up to their first violation, in turns, each with a dozen
sampled masses, in one thread and in two. Steps are CPU time of whole rollouts, and how many of them
a call of the engine makes; wall time means something only on a machine that has nothing else to do.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from itertools import islice, product
from typing import Any
from unittest import mock

import numpy as np
from mamo_mujoco.engine import MuJoCoWorld
from mamo_mujoco.model import MuJoCoModel
from mamo_mujoco.options import MuJoCoOptions
from measures.push import pushes

from mamo_core.interfaces.simulated_world import SimulatedWorld
from mamo_core.plugins import discover
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides
from mamo_core.warmup import load_kernels

SAMPLES = 12
ENGINES: dict[str, Any] = {"one by one": SimulatedWorld, "compiled": MuJoCoWorld}


@dataclass
class Tally:
    """CPU and wall seconds, steps, and how many of them each call of the engine made."""

    cpu: float = 0.0
    wall: float = 0.0
    steps: int = 0
    made: list[int] = field(default_factory=list)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print a table; the exit code."""
    made = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    made.add_argument("--pushes", type=int, default=10, metavar="N")
    made.add_argument("--repeats", type=int, default=3, metavar="N")
    options = made.parse_args(arguments)
    tallies = measure(options.pushes, options.repeats)
    print(
        f"{'steps':12} {'threads':>7} {'us/step':>8} {'steps/call':>10} {'wall s':>8} {'CPU s':>8}"
    )
    for (way, threads), tally in tallies.items():
        each, together = 1e6 * tally.cpu / tally.steps, np.mean(tally.made)
        print(
            f"{way:12} {threads:7} {each:8.2f} {together:10.1f} {tally.wall:8.3f} {tally.cpu:8.3f}"
        )
    return 0


def measure(count: int, repeats: int) -> dict[tuple[str, int], Tally]:
    """By way and number of threads."""
    registry = discover()
    load_kernels(registry)
    tallies = {key: Tally() for key in product(ENGINES, (1, 2))}
    for context, action in islice(pushes(registry), count):
        problem, sweep = context.problem, action.motion.after_transit()
        models = {
            threads: MuJoCoModel(
                problem, context.robot, context.constraints, MuJoCoOptions(batch_threads=threads)
            )
            for threads in (1, 2)
        }
        jobs = [problem.initial.with_joints(sweep.start)] * SAMPLES, [sweep] * SAMPLES
        masses = sampled_masses(problem)
        for model in models.values():  # their worlds are built here
            model.rollout_batch(*jobs, parameters=masses)
        for _, ((way, threads), tally) in product(range(repeats), tallies.items()):
            with _driven(way, tally.made):
                _add(tally, models[threads], jobs, masses)
    return tallies


def sampled_masses(problem: Problem) -> list[ParameterOverrides]:
    """Masses from half to twice of what they are."""
    rng = np.random.default_rng(0)
    return [
        ParameterOverrides({o.name: o.mass * rng.uniform(0.5, 2.0) for o in problem.scene.objects})
        for _ in range(SAMPLES)
    ]


def _driven(way: str, made: list[int]) -> AbstractContextManager[Any]:
    """While it lasts, the engine goes on as far as it can, or not; ``made`` gets the steps."""
    counted: dict[str, Any] = {
        name: _counted(getattr(ENGINES[way], name), made) for name in ("follow", "wait")
    }
    return mock.patch.multiple(MuJoCoWorld, **counted)


def _counted(run: Callable[..., int], made: list[int]) -> Callable[..., int]:
    def count(*arguments: Any) -> int:
        steps = run(*arguments)
        made.append(steps)  # in a thread: what is last may be another's
        return steps

    return count


def _add(tally: Tally, model: MuJoCoModel, jobs: Any, masses: list[ParameterOverrides]) -> None:
    wall, cpu = time.perf_counter(), time.process_time()
    results = model.rollout_batch(*jobs, parameters=masses)
    tally.wall += time.perf_counter() - wall
    tally.cpu += time.process_time() - cpu
    tally.steps += sum(result.steps for result in results)


if __name__ == "__main__":
    raise SystemExit(main())
