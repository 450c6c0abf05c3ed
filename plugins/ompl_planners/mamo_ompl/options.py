"""Options of the arm planners, apart from the code so that listing them imports no OMPL."""

from __future__ import annotations

from pydantic import Field

from mamo_core.hookspecs import Options


class OmplOptions(Options):
    """Options of every arm planner of OMPL."""

    max_checks: int = Field(50_000, ge=1, description="configurations checked per query")
    shortcuts: int = Field(60, ge=0, description="attempts to shorten the path")


class TreeOptions(OmplOptions):
    """Options of those that grow trees."""

    range: float = Field(
        2.0, gt=0.0, description="longest motion added to a tree, rad (norm over all joints)"
    )


class OptimalOptions(OmplOptions):
    """Options of those that can go on with a better path once there is one."""

    optimize: bool = Field(
        False, description="use up all checks for a shorter path; otherwise the first path will do"
    )


class OptimalTreeOptions(TreeOptions, OptimalOptions):
    """Options of those that grow trees and can go on with a better path."""


class BatchOptions(OmplOptions):
    """Options of those that connect a batch of samples, drawn at once."""

    samples: int = Field(200, ge=1, description="free configurations drawn per query")
