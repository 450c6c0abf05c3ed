"""Options of the engine."""

from __future__ import annotations

from pydantic import Field

from mamo_core.hookspecs import Options


class MyBackendOptions(Options):
    """What a recipe may set: ``{name: my_backend, time_step: 0.005}``."""

    time_step: float = Field(default=0.01, gt=0.0, le=0.02, description="simulation step, s")
    finger_radius: float = Field(default=0.01, gt=0.0, description="radius of a finger, m")
    max_force: float = Field(default=60.0, gt=0.0, description="the arm stalls above it, N")
