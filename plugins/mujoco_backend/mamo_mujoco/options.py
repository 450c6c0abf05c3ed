"""Options of the MuJoCo backend."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from mamo_core.hookspecs import Options


class MuJoCoOptions(Options):
    """Options of ``mujoco``; the defaults are the measured trade of speed against accuracy."""

    time_step: float = Field(0.004, gt=0.0, le=0.01, description="simulation step, s")
    stiffness: float = Field(
        4000.0, gt=0.0, description="largest position gain of the arm, N m/rad"
    )
    effort: float = Field(
        1.0, gt=0.0, le=1.0, description="share of the robot's efforts that its servos may use"
    )
    give: float = Field(
        0.0075,
        gt=0.0,
        description="error (rad) at which a joint's servo is at its effort, if it is stiff enough",
    )
    lead: float = Field(
        0.05, gt=0.0, description="velocity gain of the arm by its position gain, s"
    )
    sleep: bool = Field(True, description="let resting objects sleep: faster")
    sleep_at_once: bool = Field(
        False,
        description="let them sleep from the first step on, as they rest where a rollout begins, "
        "instead of watching them for ten steps: a tenth faster",
    )
    tolerance: float = Field(
        1e-8, gt=0.0, description="of the contact solver: it stops where it gains less"
    )
    arm_meets_fixtures: bool = Field(
        True,
        description="simulate contacts between the arm and fixtures; without them it is faster, "
        "and whether the arm keeps clear of fixtures must be found out elsewhere",
    )
    batch_threads: int = Field(
        1,
        ge=1,
        description="threads of rollout_batch; more take less time and more CPU, which is what "
        "budgets count",
    )
    grasp: Literal["weld", "friction"] = Field(
        "weld",
        description="what holds an object in the hand: weld: it is fixed to the hand, fast; "
        "friction: the force of the fingers, and friction with soft pads",
    )
