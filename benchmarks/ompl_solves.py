"""OMPL's arm planners beside rrt_connect: the same queries into a generated shelf.

    python benchmarks/ompl_solves.py --solves 1000 ompl_rrt_connect

Times are CPU milliseconds of one core. Refuted are paths that the checker does not find free when
asked motion by motion once more. A solve that crashes ends the process. Memory is what the process
has grown by, so that leaks show.
"""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from mamo_geometry.kinematics import ChainKinematics
from mamo_geometry.options import KinematicsOptions, RRTConnectOptions, SphereCheckerOptions
from mamo_geometry.rrt_connect import RRTConnect
from mamo_geometry.sphere_checker import SphereChecker
from mamo_ompl.arm_planner import OmplArmPlanner
from mamo_ompl.kinds import KINDS

from mamo_core.interfaces.arm_planner import ArmPlan, ArmPlanner
from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.problems import generate_shelf
from mamo_core.robots import load_arm
from mamo_core.robots.model import ArmModel
from mamo_core.types.geometry import Array, tool_matrix

OURS = "rrt_connect"


@dataclass
class Tally:
    """What the solves of one planner came to."""

    seconds: list[float] = field(default_factory=list)
    checks: list[int] = field(default_factory=list)
    lengths: list[float] = field(default_factory=list)
    refuted: int = 0

    def add(self, plan: ArmPlan, seconds: float) -> None:
        """Count one solve."""
        self.seconds.append(seconds)
        self.checks.append(plan.checks)
        if plan.path is not None:
            self.lengths.append(float(np.linalg.norm(np.diff(plan.path, axis=0), axis=1).sum()))

    def row(self, name: str, grown: float) -> str:
        """A line of the table."""
        middle, late = 1e3 * np.quantile(self.seconds, [0.5, 0.95])
        length = np.median(self.lengths) if self.lengths else np.nan
        return (
            f"{name:24} {len(self.lengths):5} of {len(self.seconds):5} {middle:9.2f} {late:9.2f}"
            f" {np.median(self.checks):9.0f} {length:8.2f} {self.refuted:8} {grown:8.1f}"
        )


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; the exit code."""
    made = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    made.add_argument("planners", nargs="*", help="all if none is named")
    made.add_argument("--solves", type=int, default=100, help="of each planner")
    made.add_argument("--max-checks", type=int, default=50_000)
    options = made.parse_args(arguments)
    arm = load_arm("pr2_right_arm")
    world, goals = shelf(arm)
    print(
        f"{'planner':24} {'solved':>14} {'median ms':>9} {'p95 ms':>9}"
        f" {'checks':>9} {'length':>8} {'refuted':>8} {'MB more':>8}"
    )
    for name in options.planners or [OURS, *KINDS]:
        planner = planner_of(name, arm)
        planner.plan(arm.home, goals[:1], world, np.random.default_rng(0))
        before = memory()
        tally = solves(planner, arm, world, goals, options.solves, options.max_checks)
        print(tally.row(name, memory() - before), flush=True)
    return 0


def planner_of(name: str, arm: ArmModel) -> ArmPlanner:
    """With the options it has by itself."""
    if name == OURS:
        return RRTConnect(arm, RRTConnectOptions())
    return OmplArmPlanner(arm, KINDS[name], KINDS[name].options())


def shelf(arm: ArmModel) -> tuple[CollisionWorld, Array]:
    """A cluttered shelf, and free configurations (k, dof) in it off the straight way from home."""
    problem = generate_shelf(movables=10, seed=1)
    kinematics = ChainKinematics(problem.scene, arm, KinematicsOptions())
    checker = SphereChecker(problem.scene, arm, SphereCheckerOptions())
    world = checker.world(problem.initial.object_poses, opening=0.0)
    rng = np.random.default_rng(4)
    space = problem.scene.workspace
    found = []
    for _ in range(600):
        position = rng.uniform(space.lower, space.upper) - [0.1, 0.0, 0.0]
        position[2] = space.floor + rng.uniform(0.03, 0.25)
        T = tool_matrix(position, rng.uniform(-0.8, 0.8), rng.uniform(0.0, 0.6))
        found.append(kinematics.inverse(T, rng, count=2))
    goals = np.vstack(found)
    homes = np.repeat(arm.home[None], len(goals), axis=0)
    return world, goals[world.free(goals) & ~world.edges_free(homes, goals)]


def solves(
    planner: ArmPlanner,
    arm: ArmModel,
    world: CollisionWorld,
    goals: Array,
    count: int,
    max_checks: int,
) -> Tally:
    """So many queries, each to two goals, every path checked."""
    tally = Tally()
    for seed in range(count):
        pair = goals[np.array([seed, seed + 1]) % len(goals)]
        begun = time.process_time()
        plan = planner.plan(
            arm.home, pair, world, np.random.default_rng(seed), max_checks=max_checks
        )
        tally.add(plan, time.process_time() - begun)
        tally.refuted += plan.path is not None and not confirmed(world, plan.path)
    return tally


def confirmed(world: CollisionWorld, path: Array) -> bool:
    """Whether every motion is free, asked forwards or backwards: either answer is sound."""
    forwards = world.edges_free(path[:-1], path[1:])
    return bool((forwards | world.edges_free(path[1:], path[:-1])).all())


def memory() -> float:
    """Largest memory of this process so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    raise SystemExit(main())
