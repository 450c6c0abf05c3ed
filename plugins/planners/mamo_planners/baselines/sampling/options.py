"""Options of the sampling-based baselines, apart from the code that uses them."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from mamo_core.hookspecs import Options
from mamo_planners.reaching.options import MotionOptions


class SamplingOptions(MotionOptions):
    """Options of all of them: how the arm is led, and for how long."""

    goal_bias: float = Field(
        0.05, ge=0.0, le=1.0, description="share of actions that lead to a goal configuration"
    )
    stride: float = Field(
        0.5, gt=0.0, description="longest stretch of a random action simulated at once, rad"
    )
    strides: int = Field(6, ge=1, description="stretches of a random action, at most")
    motions: int = Field(100_000, ge=1, description="motions simulated, at most")


class _GoalsOptions(Options):
    goals: int = Field(3, ge=1, description="goal configurations computed beforehand")


class KpieceOptions(SamplingOptions, _GoalsOptions):
    """Options of ``kpiece``."""

    variant: Literal["k1", "k2"] = Field(
        "k1",
        description="k1: goal configurations are computed beforehand; k2: whenever one is needed",
    )
    cell: float = Field(0.1, gt=0.0, description="size of cells of tool positions, m")


class RrtOptions(SamplingOptions, _GoalsOptions):
    """Options of ``rrt``."""


class K3Options(SamplingOptions):
    """Options of ``k3``."""

    cell: float = Field(0.05, gt=0.0, description="size of the finest cells, m")
    levels: int = Field(2, ge=1, le=5, description="levels of cells, each four times as wide")
    actions: int = Field(
        1_000_000, ge=1, description="actions tried, at most: most are never simulated"
    )
    border: float = Field(
        0.9, ge=0.0, le=1.0, description="how often a cell at the border is chosen, at least"
    )
