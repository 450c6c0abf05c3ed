"""Do fingers and friction carry what plans carry?

    python benchmarks/friction_grasps.py out/*.json

Executes plan files in MuJoCo without welds, and prints for each whether it retrieves, and how far
every object that was held ended from where the hand should have brought it; then the shares.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mamo_core.friction_engine import friction_model
from mamo_core.plan_file import read_plan
from mamo_core.plugins import Registry, discover
from mamo_core.robots import load_arm
from mamo_core.verify_friction import FrictionReport, execute_by_friction


def executed(path: Path, registry: Registry) -> FrictionReport:
    """The plan of a file, executed by friction to its end."""
    document = read_plan(path)
    robot = load_arm(document.problem.scene.robot)
    model = friction_model(document.problem, registry, robot)
    return execute_by_friction(document.problem, document.plan, model, robot, stop_early=False)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print one line a plan, and what they come to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("plans", nargs="+", type=Path)
    paths = parser.parse_args(arguments).plans
    registry, reports, began = discover(), [], time.process_time()
    for path in paths:
        report = executed(path, registry)
        reports.append(report)
        slips = ", ".join(
            f"{s.name} {1e3 * s.distance:.1f} mm {np.degrees(s.angle):.1f} deg"
            for s in report.slips
        )
        verdict = "holds" if not report.failures else "FAILS: " + "; ".join(report.failures[:2])
        print(f"{path.name:40} {verdict} ({slips})", flush=True)
    good = sum(not report.failures for report in reports)
    distances = [1e3 * slip.distance for report in reports for slip in report.slips]
    angles = [np.degrees(slip.angle) for report in reports for slip in report.slips]
    print(f"{good} of {len(reports)} plans hold by friction ({100.0 * good / len(reports):.1f} %)")
    if distances:
        print(
            f"{len(distances)} holds: median {np.median(distances):.1f} mm and "
            f"{np.median(angles):.1f} deg, largest {max(distances):.1f} mm, {max(angles):.1f} deg"
        )
    print(f"{(time.process_time() - began) / len(reports):.2f} CPU s a plan")


if __name__ == "__main__":
    main()
