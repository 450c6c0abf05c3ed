"""How often plans hold where masses and frictions differ a little from the problem's.

    mamo study export out/robust.db --plans out/plans
    python benchmarks/near_truth.py out/plans/*robust_im4m*.json

A plan that is replayed once holds or not, which says little: of pushes, a hair's breadth decides.
So each plan file is replayed several times, every mass and friction drawn anew about the problem's
own as samples of robust planners are (``--spread``: standard deviation, as a share). Plans without
actions are replayed once. The last row is the mean.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from mamo_planners.search.options import Uncertainty
from mamo_planners.search.uncertainty import sampled

from mamo_core.plan_file import read_plan
from mamo_core.plugins import Registry, discover
from mamo_core.study.replay import verifier_of
from mamo_core.warmup import load_kernels


def main(arguments: Sequence[str] | None = None) -> int:
    """Replay, and print a row for each plan that does not always hold; the exit code."""
    made = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    made.add_argument("plans", type=Path, nargs="+", metavar="PLAN.json")
    made.add_argument("--times", type=int, default=16, metavar="N")
    made.add_argument("--spread", type=float, default=0.02, metavar="SHARE")
    given = made.parse_args(arguments)
    registry = discover()
    load_kernels(registry)
    shares = {
        path: share_that_holds(path, registry, given.times, given.spread) for path in given.plans
    }
    for path, share in shares.items():
        if share < 1.0:
            print(f"{path.stem:60} {100.0 * share:6.1f} %")
    print(f"{f'all {len(shares)}':60} {100.0 * float(np.mean(list(shares.values()))):6.1f} %")
    return 0


def share_that_holds(path: Path, registry: Registry, times: int, spread: float) -> float:
    """The share of replays in which nothing fails; the same for the same file."""
    document = read_plan(path)
    about = Uncertainty(simulators=times, copies=1, mass_spread=spread, friction_spread=spread)
    draws = sampled(document.problem.scene, about, np.random.default_rng(0))
    verify = verifier_of(document, registry)
    some = draws if document.plan.actions else draws[:1]
    return float(np.mean([verify(document.plan, values).ok for values in some]))


if __name__ == "__main__":
    raise SystemExit(main())
