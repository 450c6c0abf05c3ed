"""Options of the PyBullet backend."""

from __future__ import annotations

from pydantic import Field

from mamo_core.hookspecs import Options


class PyBulletOptions(Options):
    """Options of ``pybullet``; the defaults are the measured trade of speed against accuracy."""

    time_step: float = Field(1.0 / 180.0, gt=0.0, le=0.01, description="simulation step, s")
    iterations: int = Field(20, ge=1, description="most iterations of the contact solver per step")
    position_gain: float = Field(
        0.3, gt=0.0, le=1.0, description="share of a joint's error that a servo corrects per step"
    )
    effort: float = Field(
        1.0, gt=0.0, le=1.0, description="share of the robot's efforts that its servos may use"
    )
    sleep: bool = Field(True, description="let resting objects sleep: faster")
    workers: int = Field(
        1, ge=0, description="engine processes; 0: in this process, where a crash ends everything"
    )
    patience: float = Field(
        60.0, gt=0.0, description="wall time after which a rollout counts as hung, s"
    )
