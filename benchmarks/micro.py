"""Speed of the parts beside their targets, all measured side by side in one run.

    python benchmarks/micro.py --json out/micro.json        (or: make bench)

Scenes are generated and seeded. Times are CPU seconds of one core, but for what a user waits for:
the help and the first compilation, which are wall time. Kernels are compiled before.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True)
class Target:
    """What a figure should be: at least or at most ``limit``."""

    label: str
    at_least: bool
    limit: float
    unit: str = ""

    def met(self, value: float) -> bool:
        """Whether the figure is good enough."""
        return value >= self.limit if self.at_least else value <= self.limit

    def __str__(self) -> str:
        return f"{'>=' if self.at_least else '<='} {self.limit:g}{self.unit}"


TARGETS = {
    "config_checks_per_s": Target("configuration checks per second", True, 1e6),
    "checks_vs_fcl": Target("... times python-fcl's", True, 50),
    "missed_collisions": Target("... mesh collisions missed", False, 0),
    "arm_plan_ms_median": Target("RRT-Connect into a shelf, median", False, 5, " ms"),
    "mapf10_ms_median": Target("MAPF, 10 movables, median", False, 3, " ms"),
    "mapf15_ms_p95": Target("MAPF, 15 movables, p95", False, 50, " ms"),
    "push_cpu_s": Target("simulated push, 15 objects, median", False, 0.12, " s"),
    "compile_s": Target("first compilation", False, 30, " s"),
    "help_s": Target("mamo --help", False, 0.5, " s"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print the table, perhaps write it; the exit code."""
    made = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    made.add_argument("--json", type=Path, metavar="OUT", help="write the figures here")
    options = made.parse_args(arguments)
    os.environ.update(dict.fromkeys(THREADS, "1"))  # before numpy is imported
    values, how = measure_all()
    if options.json is not None:
        from mamo_core.atomic import atomic_path

        with atomic_path(options.json) as work:
            work.write_text(json.dumps(document(values, how), indent=1) + "\n")
    print(table(values, how))
    return 0


def measure_all() -> tuple[dict[str, float], dict[str, str]]:
    """All figures, and how each was measured."""
    from measures import arm, collision, mapf, push, startup

    from mamo_core.plugins import discover
    from mamo_core.warmup import load_kernels, warm_up

    registry = discover()
    for piece in warm_up(registry):
        _tell(f"warm-up: {piece}")
    load_kernels(registry)
    parts: tuple[tuple[str, Callable[[], Any]], ...] = (
        ("collision checks", lambda: collision.measure(registry)),
        ("arm planning", lambda: arm.measure(registry)),
        ("MAPF", lambda: mapf.measure(registry)),
        ("pushes", lambda: push.measure(registry)),
        ("help", startup.measure_help),
        ("first compilation", startup.measure_compilation),
    )
    values: dict[str, float] = {}
    how: dict[str, str] = {}
    for name, measure in parts:
        _tell(f"measuring: {name}")
        measured = measure()
        values |= measured.values
        how |= measured.how
    return values, how


def document(values: dict[str, float], how: dict[str, str]) -> dict[str, Any]:
    """The figures as plain data."""
    from mamo_core.plan_file import package_versions

    return {
        "schema_version": 1,
        **{key: values[key] for key in TARGETS},
        "met": {key: target.met(values[key]) for key, target in TARGETS.items()},
        "how": how,
        "machine": {"processor": platform.machine(), "cores": os.cpu_count()},
        "versions": {"python": platform.python_version(), **package_versions()},
    }


def table(values: dict[str, float], how: dict[str, str]) -> str:
    """A Markdown table, the target beside each figure."""
    from mamo_core.study.tables import markdown

    header = ("figure", "measured", "target", "met", "how")
    return markdown(
        header,
        [
            [t.label, f"{_figure(values[key])}{t.unit}", str(t), _yes(t, values[key]), how[key]]
            for key, t in TARGETS.items()
        ],
    )


def _yes(target: Target, value: float) -> str:
    return "yes" if target.met(value) else "NO"


def _figure(value: float) -> str:
    return f"{value:,.0f}" if value >= 100 or value == int(value) else f"{value:.3g}"


def _tell(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
