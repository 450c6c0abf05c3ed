"""MuJoCo's steps one by one, as the default of the interface has it, and in compiled stretches.

    python benchmarks/steps.py

The same pushes on a shelf with 15 objects to their end, in turns. Steps are CPU time of a whole
rollout. Then each push with a dozen sampled masses, in one thread and in two: how long these ran,
and how long they were blocked, neither running nor waiting for a core (Linux counts that), which is
waiting for the interpreter. Wall time would say how busy the machine is.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import partial
from itertools import islice, product
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from mamo_mujoco.engine import MuJoCoWorld
from measures.push import pushes

from mamo_core.interfaces.simulated_world import SimulatedWorld
from mamo_core.interfaces.transition_model import RolloutOptions
from mamo_core.plugins import discover
from mamo_core.types.geometry import Array
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.warmup import load_kernels

SAMPLES = 12
TO_THE_END = RolloutOptions(stop_early=False)

Rollout = Callable[[ParameterOverrides | None], RolloutResult]


@dataclass
class Tally:
    """CPU seconds and steps of single rollouts; of the samples (2,): ran, blocked, s."""

    seconds: float = 0.0
    steps: int = 0
    samples: Array | float = 0.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print a table; the exit code."""
    made = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    made.add_argument("--pushes", type=int, default=20, metavar="N")
    made.add_argument("--repeats", type=int, default=5, metavar="N")
    options = made.parse_args(arguments)
    tallies = measure(options.pushes, options.repeats)
    print(f"{'steps':12} {'threads':>7} {'us/step':>8} {'ran s':>8} {'blocked s':>10}")
    for (way, threads), tally in tallies.items():
        ran, blocked = np.broadcast_to(tally.samples, 2)
        each = 1e6 * tally.seconds / tally.steps
        print(f"{way:12} {threads:7} {each:8.2f} {ran:8.3f} {blocked:10.3f}")
    return 0


def measure(count: int, repeats: int) -> dict[tuple[str, int], Tally]:
    """By way and number of threads."""
    registry = discover()
    load_kernels(registry)
    tallies = {key: Tally() for key in product(("one by one", "compiled"), (1, 2))}
    for context, action in islice(pushes(registry), count):
        sweep = action.motion.after_transit()
        state = context.problem.initial.with_joints(sweep.start)
        model = context.part("backend")
        rollout = partial(_rollout, model, state, sweep)
        sets = _sampled(context.problem)
        for _, ((way, threads), tally) in product(range(repeats), tallies.items()):
            with _driven(way):
                _add(tally, rollout, sets, threads)
    return tallies


def _rollout(
    model: Any, state: Any, motion: Any, values: ParameterOverrides | None
) -> RolloutResult:
    result: RolloutResult = model.rollout(state, motion, parameters=values, options=TO_THE_END)
    return result


def _sampled(problem: Problem) -> list[ParameterOverrides]:
    """Masses from half to twice of what they are."""
    rng = np.random.default_rng(0)
    return [
        ParameterOverrides({o.name: o.mass * rng.uniform(0.5, 2.0) for o in problem.scene.objects})
        for _ in range(SAMPLES)
    ]


def _driven(way: str) -> AbstractContextManager[Any]:
    """While it lasts, the engine goes on as far as it can, or not."""
    if way == "compiled":
        return nullcontext()
    default: dict[str, Any] = {"follow": SimulatedWorld.follow, "wait": SimulatedWorld.wait}
    return mock.patch.multiple(MuJoCoWorld, **default)


def _add(tally: Tally, rollout: Rollout, sets: list[ParameterOverrides], threads: int) -> None:
    started = time.thread_time()
    tally.steps += rollout(None).steps
    tally.seconds += time.thread_time() - started
    with ThreadPoolExecutor(threads) as pool:
        shares = pool.map(partial(_share, rollout), (sets[i::threads] for i in range(threads)))
        tally.samples = tally.samples + np.sum(list(shares), axis=0)


def _share(rollout: Rollout, sets: list[ParameterOverrides]) -> Array:
    """What one thread does of the samples: seconds it ran, and was blocked."""
    before, started = _scheduled(), time.perf_counter()
    for values in sets:
        rollout(values)
    wall, (ran, queued) = time.perf_counter() - started, _scheduled() - before
    return np.array([ran, wall - ran - queued])


def _scheduled() -> Array:
    """Seconds that this thread ran and that it waited for a core."""
    return 1e-9 * np.array(Path("/proc/thread-self/schedstat").read_text().split()[:2], dtype=float)


if __name__ == "__main__":
    raise SystemExit(main())
