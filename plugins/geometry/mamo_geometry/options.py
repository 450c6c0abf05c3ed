"""Options of the geometry parts, apart from the code so that listing them imports no kernels."""

from __future__ import annotations

from pydantic import Field

from mamo_core.hookspecs import Options


class KinematicsOptions(Options):
    """Options of ``dls``."""

    attempts: int = Field(4, ge=1, description="random restarts per wanted solution")
    apart: float = Field(
        0.3, gt=0.0, description="solutions closer than this in every joint count as one, rad"
    )


class SphereCheckerOptions(Options):
    """Options of ``spheres``."""

    margin: float = Field(0.002, ge=0.0, le=0.05, description="distance always kept, m")
    max_held_tilt_deg: float = Field(
        18.0, gt=0.0, le=180.0, description="largest tilt of a held object, degrees"
    )
    region_resolution: float = Field(0.01, gt=0.001, description="cell size of swept regions, m")


class RRTConnectOptions(Options):
    """Options of ``rrt_connect``."""

    max_checks: int = Field(50_000, ge=1, description="configurations checked per query")
    shortcuts: int = Field(60, ge=0, description="attempts to shorten the path")
