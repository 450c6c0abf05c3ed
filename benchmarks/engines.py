"""What engines promise, how far they agree, and whether plans made with one hold in the others.

    python benchmarks/engines.py grades
    python benchmarks/engines.py pushes SET... --count 40
    python benchmarks/engines.py transfer SET... --limit 20 --json out/transfer.json

``grades`` runs the conformance suite. ``pushes`` executes pushes that are valid in the first engine
in all of them. ``transfer`` plans with a recipe and replays every plan from its start in all
engines; with --json it can be interrupted, and the same command goes on where it stopped.
Everything runs in this process.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def parser() -> argparse.ArgumentParser:
    """The command line."""
    made = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    made.add_argument("what", choices=("grades", "pushes", "transfer"))
    made.add_argument("sets", nargs="*", type=Path, metavar="SET", help="problem files")
    made.add_argument("--backends", default="mujoco,pybullet,dart", metavar="A,B,...")
    made.add_argument("--planner", default="m4m", metavar="NAME|FILE", help="recipe")
    made.add_argument("--set", action="append", default=[], dest="settings", metavar="KEY=VALUE")
    made.add_argument("--count", type=int, default=40, metavar="N", help="pushes")
    made.add_argument("--every", type=int, default=1, metavar="K", help="every K-th problem")
    made.add_argument("--limit", type=int, metavar="N", help="at most N problems of a set")
    made.add_argument("--budget", type=float, default=60.0, metavar="S", help="CPU seconds each")
    made.add_argument("--seed", type=int, default=0, metavar="N")
    made.add_argument("--json", type=Path, metavar="OUT", help="rows; finished ones are kept")
    return made


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; the exit code."""
    options = parser().parse_args(arguments)
    os.environ.update(dict.fromkeys(THREADS, "1"))  # before numpy is imported
    from mamo_core.errors import MamoError

    try:
        run = {"grades": _grades, "pushes": _pushes, "transfer": _transfer}[options.what]
        print(run(options, options.backends.split(",")))
    except MamoError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    return 0


def _grades(options: argparse.Namespace, engines: list[str]) -> str:
    from measures.engine_grades import grades_table

    from mamo_core.plugins import discover
    from mamo_core.warmup import load_kernels

    registry = discover()
    load_kernels(registry)
    return grades_table(registry, engines)


def _pushes(options: argparse.Namespace, engines: list[str]) -> str:
    from measures.engine_pushes import run_pushes, tables

    from mamo_core.plugins import discover
    from mamo_core.study.problems import pick
    from mamo_core.warmup import load_kernels

    registry = discover()
    load_kernels(registry)
    picked = pick(options.sets, options.every, options.limit)
    runs = []
    for run in run_pushes(picked, registry, engines, options.count):
        runs.append(run)
        print(f"[{len(runs)}/{options.count}]", file=sys.stderr, flush=True)
    return tables(runs, engines)


def _transfer(options: argparse.Namespace, engines: list[str]) -> str:
    from measures.engine_transfer import line_of, transfer_row, transfer_table
    from row_file import RowFile, identity

    from mamo_core.plugins import discover
    from mamo_core.recipe_sets import chosen_recipe
    from mamo_core.study.problems import pick
    from mamo_core.warmup import load_kernels

    registry = discover()
    load_kernels(registry)
    recipe = chosen_recipe(options.planner, None, tuple(options.settings))
    rows = RowFile(options.json, identity(recipe, options.budget, options.seed))
    rows.load()
    picked = pick(options.sets, options.every, options.limit)
    for number, entry in enumerate(picked, 1):
        if rows.find(entry.key) is None:
            row = transfer_row(entry, recipe, registry, engines, options.budget, options.seed)
            rows.add(row)
            print(f"[{number}/{len(picked)}] {line_of(row)}", file=sys.stderr, flush=True)
    return transfer_table(rows.rows, engines)


if __name__ == "__main__":
    sys.exit(main())
