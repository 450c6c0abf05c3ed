"""How often, and how fast, a planner solves sets of problems, on one core.

    python benchmarks/success.py SET... --planner m4m --budget 60 --json out/m4m.json

Problems are solved one after another in this process. The budget is CPU seconds; it covers
building the scene and the planner, planning, and the planner's own verification. Every plan is
then written, read back and replayed in a freshly built model, which is not counted. With --json
the run can be interrupted; the same command goes on where it stopped.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
INTERRUPTED = 130


def parser() -> argparse.ArgumentParser:
    """The command line."""
    made = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    made.add_argument("sets", nargs="+", type=Path, metavar="SET", help="problem files")
    made.add_argument("--planner", default="m4m", metavar="NAME|FILE", help="recipe")
    made.add_argument(
        "--set",
        action="append",
        default=[],
        dest="settings",
        metavar="KEY=VALUE",
        help="change the recipe; may be repeated",
    )
    made.add_argument("--budget", type=float, default=60.0, metavar="S", help="CPU seconds each")
    made.add_argument("--every", type=_positive, default=1, metavar="K", help="every K-th problem")
    made.add_argument("--limit", type=_positive, metavar="N", help="at most N problems of a set")
    made.add_argument("--seed", type=int, default=0, metavar="N")
    made.add_argument("--json", type=Path, metavar="OUT", help="rows; finished ones are kept")
    made.add_argument("--fresh", action="store_true", help="forget the rows that OUT holds")
    return made


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text}, expected 1 or more")
    return number


def main(arguments: Sequence[str] | None = None) -> int:
    """Solve, and print the tables; the exit code."""
    options = parser().parse_args(arguments)
    os.environ.update(dict.fromkeys(THREADS, "1"))  # before numpy is imported
    from success_rows import RowFile, identity
    from success_runner import Runner, pick
    from success_tables import report

    from mamo_core.errors import MamoError

    try:
        runner = Runner(options.planner, tuple(options.settings), options.budget, options.seed)
        picked = pick(options.sets, options.every, options.limit)
        rows = RowFile(options.json, identity(runner.recipe, options.budget, options.seed))
        rows.load(fresh=options.fresh)
        interrupted = not runner.run(picked, rows)
    except MamoError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    wanted = {entry.key for entry in picked}
    print(report([row for row in rows.rows if (row["set"], row["id"]) in wanted], options.budget))
    return INTERRUPTED if interrupted else 0


if __name__ == "__main__":
    sys.exit(main())
