"""How often plans hold where the world is not quite what their problem says.

    for id in 100000 200000 300000; do mamo plan ... -o out/plans/$id.json; done
    python benchmarks/holds.py out/plans/*.json

Each plan is executed blindly, in one continuous simulation, in worlds whose objects stand elsewhere
by up to a distance and an angle, and weigh and rub otherwise (``--worlds``: of each deviation). A
replay holds if every limit is kept and the target ends in the hand. The last row is all replays
together; ``verified`` counts the plans that the verifier, asked again, still calls verified.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from mamo_core.choices import choose
from mamo_core.compose import build_parts
from mamo_core.config import Located
from mamo_core.margin import DEVIATIONS, share_that_holds
from mamo_core.plan_file import read_plan
from mamo_core.plugins import Registry, discover
from mamo_core.recipes import load_recipe
from mamo_core.types.deviation import Deviation
from mamo_core.warmup import load_kernels

WORLDS: Mapping[str, Deviation] = {"1 um": Deviation(1e-6, 0.0), **DEVIATIONS}


def main(arguments: Sequence[str] | None = None) -> int:
    """Execute all plans in all worlds and print a row for each; the exit code."""
    made = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    made.add_argument("plans", type=Path, nargs="+", metavar="PLAN.json")
    made.add_argument("--worlds", type=int, default=10, metavar="N")
    given = made.parse_args(arguments)
    registry = discover()
    load_kernels(registry)
    print(f"{'':40} {'actions':>8} {'verified':>9}" + "".join(f"{w:>19}" for w in WORLDS))
    rows = []
    for path in given.plans:
        actions, verified, shares = measured(path, registry, given.worlds)
        rows.append([float(verified), *shares])
        print(_row(path.stem, str(actions), "yes" if verified else "NO", shares), flush=True)
    means = np.mean(rows, axis=0)
    print(_row(f"all {len(rows)}", "", f"{100.0 * means[0]:.1f} %", means[1:].tolist()))
    return 0


def measured(path: Path, registry: Registry, worlds: int) -> tuple[int, bool, list[float]]:
    """How many actions a plan has, whether it is verified, and its shares in ``WORLDS``."""
    document = read_plan(path)
    recipe = load_recipe(Located(dict(document.recipe), f"{path}: recipe"))
    choices = choose(recipe, document.problem, registry, ("constraint", "backend"))
    parts = build_parts(choices, document.problem)
    ok = parts.part("verifier")(document.plan).ok
    what = document.problem, document.plan, parts.part("backend"), parts.robot
    shares = [share_that_holds(*what, deviation, worlds) for deviation in WORLDS.values()]
    return len(document.plan.actions), ok, shares


def _row(name: str, actions: str, verified: str, shares: Sequence[float]) -> str:
    figures = "".join(f"{100.0 * share:17.1f} %" for share in shares)
    return f"{name:40} {actions:>8} {verified:>9}{figures}"


if __name__ == "__main__":
    raise SystemExit(main())
