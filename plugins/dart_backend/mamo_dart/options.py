"""Options of the DART backend."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from mamo_core.hookspecs import Options


class DARTOptions(Options):
    """Options of ``dart``; the defaults are the measured trade of speed against accuracy."""

    time_step: float = Field(0.005, gt=0.0, le=0.01, description="simulation step, s")
    contacts: Literal["cones", "boxes"] = Field(
        "cones",
        description="cones: circular friction cones (NSGS); boxes: pyramids (Dantzig), faster and "
        "off by a third for pushes across the grid",
    )
    sweeps: int = Field(10, ge=1, description="most sweeps of the cone solver per step")
    tolerance: float = Field(1e-3, gt=0.0, description="the cone solver ends below this error, m/s")
    sleep: bool = Field(True, description="let resting objects sleep: much faster")
    contacts_every: int = Field(
        4, ge=1, description="steps between two looks at the contacts, which are slow to read"
    )
    effort: float = Field(
        1.0, gt=0.0, le=1.0, description="share of the robot's efforts that its servos may use"
    )
    workers: int = Field(
        1, ge=0, description="engine processes; 0: in this process, where a crash ends everything"
    )
    patience: float = Field(
        60.0, gt=0.0, description="wall time after which a rollout counts as hung, s"
    )
