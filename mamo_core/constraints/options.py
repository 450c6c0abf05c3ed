"""Options of the standard constraints."""

from __future__ import annotations

from pydantic import Field

from mamo_core.hookspecs import Options


class ContactOptions(Options):
    """Options of ``contact``: none."""


class TiltOptions(Options):
    """Options of ``tilt``."""

    limit_deg: float = Field(
        25.0, gt=0.0, le=180.0, description="largest angle of a body's z axis to its start, degrees"
    )


class SpeedOptions(Options):
    """Options of ``speed``."""

    limit: float = Field(1.0, gt=0.0, description="largest speed of an object's centre, m/s")


class BoundsOptions(Options):
    """Options of ``bounds``."""

    drop: float = Field(
        0.05, gt=0.0, description="an object's centre this far below its start height fell, m"
    )
