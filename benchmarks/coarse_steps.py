"""What samples are spared in MuJoCo saves, and what it changes.

    python benchmarks/coarse_steps.py

The same pushes on a shelf with 15 objects, each with a dozen sampled masses, up to their first
violation. CPU time is of whole rollouts, in turns. What changes is the largest distance between
where an object ends and where it ends as recipes have it, of pushes that are valid both times, and
how many are valid only one time. The first row tells what chance does: objects stand elsewhere by
0.1 mm.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import islice, product
from typing import Any

import numpy as np
from mamo_mujoco.model import MuJoCoModel
from mamo_mujoco.options import MuJoCoOptions
from measures.push import pushes
from steps import sampled_masses

from mamo_core.plugins import discover
from mamo_core.types.motion import Motion
from mamo_core.types.rollout import ParameterOverrides, RolloutResult
from mamo_core.types.scene import SceneState
from mamo_core.warmup import load_kernels

_QUICK = {"time_step": 0.010, "sleep_at_once": True}
WAYS: dict[str, dict[str, Any]] = {
    "4 ms, moved by 0.1 mm": {},
    "4 ms, sleep at once": {"sleep_at_once": True},
    "10 ms": {"time_step": 0.010},
    "10 ms, sleep at once": _QUICK,
    "and tolerance 1e-4": {**_QUICK, "tolerance": 1e-4},
    "and arm past fixtures": {**_QUICK, "tolerance": 1e-4, "arm_meets_fixtures": False},
}
_NUDGE = 1e-4


@dataclass
class Tally:
    """CPU seconds of ``own`` rollouts and of these, differences (m), and verdicts of both."""

    own: float = 0.0
    cpu: float = 0.0
    differences: list[float] = field(default_factory=list)
    verdicts: list[tuple[bool, bool]] = field(default_factory=list)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print a table; the exit code."""
    made = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    made.add_argument("--pushes", type=int, default=40, metavar="N")
    tallies = measure(made.parse_args(arguments).pushes)
    print(
        f"{'':22} {'CPU, share':>10} {'median mm':>9} {'p90 mm':>7} "
        f"{'valid both':>10} {'only before':>11} {'only now':>8}"
    )
    for way, tally in tallies.items():
        median, p90 = 1e3 * np.quantile(tally.differences or [np.nan], [0.5, 0.9])
        counts = [
            tally.verdicts.count(kind) for kind in ((True, True), (True, False), (False, True))
        ]
        print(
            f"{way:22} {tally.cpu / tally.own:10.2f} {median:9.1f} {p90:7.1f} "
            f"{counts[0]:10} {counts[1]:11} {counts[2]:8}"
        )
    return 0


def measure(count: int) -> dict[str, Tally]:
    """By way."""
    registry = discover()
    load_kernels(registry)
    rng = np.random.default_rng(0)
    tallies = {way: Tally() for way in WAYS}
    for context, action in islice(pushes(registry), count):
        problem, sweep = context.problem, action.motion.after_transit()
        parts = problem, context.robot, context.constraints
        start = problem.initial.with_joints(sweep.start)
        nudges = _NUDGE * rng.choice([-1.0, 1.0], size=(len(start.object_poses), 2))
        masses = sampled_masses(problem)
        models = {
            way: MuJoCoModel(*parts, MuJoCoOptions(**options)) for way, options in WAYS.items()
        }
        own = MuJoCoModel(*parts, MuJoCoOptions())
        starts = dict.fromkeys(WAYS, start) | {next(iter(WAYS)): _nudged(start, nudges)}
        for model in (own, *models.values()):  # their worlds are built here
            model.rollout_batch([start] * len(masses), [sweep] * len(masses), parameters=masses)
        for parameters, (way, tally) in product(masses, tallies.items()):
            before, own_seconds = _timed(own, start, sweep, parameters)
            now, seconds = _timed(models[way], starts[way], sweep, parameters)
            _add(tally, before, now, own_seconds, seconds)
    return tallies


def _timed(
    model: MuJoCoModel, start: SceneState, sweep: Motion, parameters: ParameterOverrides
) -> tuple[RolloutResult, float]:
    """A rollout and its CPU seconds."""
    started = time.process_time()
    result = model.rollout(start, sweep, parameters=parameters)
    return result, time.process_time() - started


def _nudged(state: SceneState, nudges: Any) -> SceneState:
    poses = state.object_poses.copy()
    poses[:, :2] += nudges
    return SceneState(state.joint_positions, poses)


def _add(
    tally: Tally, before: RolloutResult, now: RolloutResult, own: float, seconds: float
) -> None:
    tally.own += own
    tally.cpu += seconds
    tally.verdicts.append((before.valid, now.valid))
    if before.valid and now.valid:
        apart = now.final_state.object_poses[:, :3] - before.final_state.object_poses[:, :3]
        tally.differences.append(float(np.linalg.norm(apart, axis=1).max()))


if __name__ == "__main__":
    raise SystemExit(main())
