"""Options of the baselines, apart from the code that uses them."""

from __future__ import annotations

from pydantic import Field

from mamo_core.hookspecs import Options
from mamo_planners.reaching.options import LatticeOptions


class SelectiveSimulationOptions(LatticeOptions):
    """Options of ``selective_simulation`` (SelSim, SS; SS2 with ``beta``)."""

    expansions: int = Field(10_000_000, ge=1, description="states expanded by one planning phase")
    snap_distance: float = Field(
        0.1, gt=0.0, description="of the tool to the goal, where the straight motion is tried, m"
    )
    position_cell: float = Field(
        0.01, gt=0.0, description="relevant objects this close are in the same place, m"
    )
    yaw_cell_deg: float = Field(
        5.0, gt=0.0, description="relevant objects turned by less stand the same way, degrees"
    )
    beta: float | None = Field(
        None,
        gt=0.0,
        description="distance to a state whose simulated motion failed within which others are put "
        "off, rad (SS2; null: never)",
    )


class DogarOptions(Options):
    """Options of ``dogar``."""

    goal_spread: float = Field(
        0.05, ge=0.0, description="standard deviation of goals around the closest free cell, m"
    )
    goals: int = Field(10, ge=1, description="goals drawn for an object before it is given up")
    attempts: int = Field(1000, ge=1, description="recursions begun anew, with another retrieval")
    cell: float = Field(0.01, gt=0.0, description="grid on which the closest free cell is, m")
