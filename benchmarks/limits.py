"""What plans use of the robot's limits, seen at 1 kHz, and how long they take.

    python benchmarks/limits.py PLANS...

Prints of each plan, and of all together, the largest share of a joint's velocity, acceleration and
jerk limit and of the gripper's speed, the largest share of a joint's effort in a replay in MuJoCo
(with ``--effort``), and the seconds that its motions take.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from mamo_core.plan_file import PlanDocument, read_plan
from mamo_core.robots.library import load_arm
from mamo_core.robots.model import ArmModel
from mamo_core.types.motion import Motion
from mamo_core.verify_limits import gripper_share, shares

KINDS = ("velocity", "acceleration", "jerk", "gripper", "effort")


def used(document: PlanDocument, arm: ArmModel, *, effort: bool) -> dict[str, float]:
    """Largest shares of the limits by kind, and ``seconds`` of the motions."""
    found = dict.fromkeys(KINDS, 0.0)
    for motion in document.plan.motions:
        opening = motion.opening
        for segment in motion.segments:
            for kind, share in shares(segment.trajectory, arm).items():
                found[kind] = max(found[kind], float(share.max()))
            found["gripper"] = max(found["gripper"], gripper_share(segment, opening, arm.gripper))
            opening = segment.opening
    if effort:
        found["effort"] = float(efforts(document, arm).max())
    return {**found, "seconds": sum(motion.duration for motion in document.plan.motions)}


def efforts(document: PlanDocument, arm: ArmModel) -> Any:
    """Largest share (dof,) of each joint's effort while the whole plan is replayed in MuJoCo."""
    from mamo_mujoco.engine import MuJoCoWorld
    from mamo_mujoco.model import MuJoCoWorlds
    from mamo_mujoco.options import MuJoCoOptions

    from mamo_core.interfaces.transition_model import RolloutOptions
    from mamo_core.simulation.model import SimulatedModel

    largest = np.zeros(arm.dof)
    worlds = MuJoCoWorlds(document.problem, arm, MuJoCoOptions(), 0.0)

    def watched(parameters: Any) -> MuJoCoWorld:
        world = worlds(parameters)
        step = world.step

        def measured() -> None:
            step()
            np.maximum(largest, np.abs(world.efforts()) / arm.effort, out=largest)

        world.step = measured  # type: ignore[method-assign]
        return world

    plan = document.plan
    segments = tuple(segment for motion in plan.motions for segment in motion.segments)
    model = SimulatedModel(document.problem, arm, (), watched)
    whole = Motion(segments, plan.motions[0].opening)
    # With a trace every step is taken one by one, so that it can be watched.
    model.rollout(
        document.problem.initial, whole, options=RolloutOptions(stop_early=False, trace_step=0.1)
    )
    return largest


def main() -> None:
    """Read the plans and print what they use."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("plans", nargs="+", type=Path)
    parser.add_argument("--effort", action="store_true", help="replay each plan in MuJoCo, too")
    arguments = parser.parse_args()
    print(f"{'plan':32}" + "".join(f"{kind:>14}" for kind in (*KINDS, "seconds")))
    rows = []
    for path in arguments.plans:
        document = read_plan(path)
        arm = load_arm(document.problem.scene.robot)
        row = used(document, arm, effort=arguments.effort)
        rows.append(list(row.values()))
        print(_line(path.stem, rows[-1]))
    table = np.array(rows)
    print(_line("all", [*table[:, :-1].max(axis=0), table[:, -1].sum()]))


def _line(name: str, values: list[float]) -> str:
    cells = [f"{100.0 * value:13.1f}%" for value in values[:-1]]
    return f"{name[:32]:32}" + "".join(cells) + f"{values[-1]:13.2f}s"


if __name__ == "__main__":
    main()
