"""Options of the standard constraints."""

from __future__ import annotations

from collections.abc import Mapping

from pydantic import Field

from mamo_core.hookspecs import Options


class ContactOptions(Options):
    """Options of ``contact``."""

    clearance: float = Field(
        0.0,
        ge=0.0,
        description="movable objects touch immovable ones and the target from this distance on, m; "
        "those that begin within twice of it, from half of theirs on",
    )

    def needs(self) -> Mapping[str, frozenset[str]]:
        needed = frozenset({"clearance"} if self.clearance > 0.0 else ())
        return {"backend": needed, "accept_in": needed}


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


class PenetrationOptions(Options):
    """Options of ``penetration``."""

    limit: float = Field(
        0.002, gt=0.0, description="how far two things may reach into each other, m"
    )
