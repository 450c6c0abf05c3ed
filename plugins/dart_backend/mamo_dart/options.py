"""Options of the DART backend."""

from __future__ import annotations

from pydantic import Field

from mamo_core.hookspecs import Options


class DARTOptions(Options):
    """Options of ``dart``; the defaults are the measured trade of speed against accuracy."""

    time_step: float = Field(0.004, gt=0.0, le=0.01, description="simulation step, s")
    workers: int = Field(
        1, ge=0, description="engine processes; 0: in this process, where a crash ends everything"
    )
    patience: float = Field(
        60.0, gt=0.0, description="wall time after which a rollout counts as hung, s"
    )
