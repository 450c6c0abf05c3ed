"""The multi-agent pathfinding components; nothing is compiled or imported before one is built."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from mamo_core.hookspecs import Component, Options
from mamo_core.interfaces.mapf_solver import MAPFSolver

_CANDIDATES = "conflicts tried at a node before the best one to split is kept (count)"
_ORDERS = "priority orders tried before giving up (count)"


class CBSOptions(Options):
    """Optimal conflict-based search."""

    candidates: int = Field(4, ge=1, description=_CANDIDATES)


class ECBSOptions(Options):
    """Conflict-based search within a factor of the optimum."""

    w: float = Field(1.5, ge=1.0, description="cost at most this times the optimum (factor)")
    candidates: int = Field(1, ge=1, description=_CANDIDATES)
    flexible: bool = Field(True, description="one agent may use the slack that others leave")


class PrioritizedOptions(Options):
    """Prioritised planning."""

    orders: int = Field(100, ge=1, description=_ORDERS)


class PortfolioOptions(Options):
    """Shares are parts of the whole budget of work; prioritised planning has the rest."""

    cbs_share: float = Field(0.006, ge=0.0, le=1.0, description="share of optimal CBS (fraction)")
    candidates: int = Field(2, ge=1, description=_CANDIDATES)
    w: float = Field(1.5, ge=1.0, description="factor of the first ECBS")
    w_share: float = Field(0.015, ge=0.0, le=1.0, description="share of the first ECBS (fraction)")
    w_loose: float = Field(3.0, ge=1.0, description="factor of the second ECBS")
    loose_share: float = Field(
        0.10, ge=0.0, le=1.0, description="share of the second ECBS (fraction)"
    )
    orders: int = Field(1000, ge=1, description=_ORDERS)


def build_cbs(context: Any, options: CBSOptions) -> MAPFSolver:
    """Optimal CBS."""
    from mamo_planners.mapf.solvers import cbs

    return cbs(options.candidates)


def build_ecbs(context: Any, options: ECBSOptions) -> MAPFSolver:
    """ECBS with factor ``w``."""
    from mamo_planners.mapf.solvers import ecbs

    return ecbs(options.w, options.candidates, options.flexible)


def build_prioritized(context: Any, options: PrioritizedOptions) -> MAPFSolver:
    """Prioritised planning with random orders."""
    from mamo_planners.mapf.solvers import prioritized_planning

    return prioritized_planning(options.orders)


def build_portfolio(context: Any, options: PortfolioOptions) -> MAPFSolver:
    """CBS, then ECBS twice, then prioritised planning."""
    from mamo_planners.mapf.solvers import portfolio

    return portfolio(
        options.cbs_share,
        options.candidates,
        (options.w_share, options.w),
        (options.loose_share, options.w_loose),
        options.orders,
    )


COMPONENTS: list[Component] = [
    Component(
        "portfolio",
        build_portfolio,
        PortfolioOptions,
        "optimal if that is cheap to find, bounded if not, any solution at last",
    ),
    Component("cbs", build_cbs, CBSOptions, "optimal conflict-based search"),
    Component("ecbs", build_ecbs, ECBSOptions, "conflict-based search within a factor"),
    Component(
        "prioritized", build_prioritized, PrioritizedOptions, "one agent after another; incomplete"
    ),
]
