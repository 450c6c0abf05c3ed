"""Which planners of OMPL there are, and how each is set up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mamo_ompl.options import (
    BatchOptions,
    OmplOptions,
    OptimalOptions,
    OptimalTreeOptions,
    TreeOptions,
)


@dataclass(frozen=True)
class Kind:
    """A planner of ``ompl.geometric``: its class, our options, and what passes them on."""

    planner: str
    options: type[OmplOptions]
    summary: str
    set_up: Callable[[Any, Any], None]


def _range(planner: Any, options: TreeOptions) -> None:
    planner.setRange(options.range)


def _samples(planner: Any, options: BatchOptions) -> None:
    planner.setNumSamples(options.samples)


def _nothing(planner: Any, options: OmplOptions) -> None:
    """What there is to set is set in the objective."""


KINDS: dict[str, Kind] = {
    "ompl_rrt_connect": Kind(
        "RRTConnect", TreeOptions, "a tree from each end (Kuffner and LaValle 2000)", _range
    ),
    "ompl_rrt": Kind("RRT", TreeOptions, "one tree from the start (LaValle 1998)", _range),
    "ompl_kpiece": Kind(
        "KPIECE1", TreeOptions, "a tree that prefers sparse cells (Sucan and Kavraki 2009)", _range
    ),
    "ompl_bkpiece": Kind("BKPIECE1", TreeOptions, "KPIECE from both ends", _range),
    "ompl_lbkpiece": Kind(
        "LBKPIECE1", TreeOptions, "KPIECE from both ends, edges checked when needed", _range
    ),
    "ompl_rrt_star": Kind(
        "RRTstar",
        OptimalTreeOptions,
        "a tree that is rewired for short paths (Karaman and Frazzoli 2011)",
        _range,
    ),
    "ompl_informed_rrt_star": Kind(
        "InformedRRTstar",
        OptimalTreeOptions,
        "RRT* that samples where paths can get shorter (Gammell et al. 2014)",
        _range,
    ),
    "ompl_sorrt_star": Kind(
        "SORRTstar",
        OptimalTreeOptions,
        "Informed RRT* that takes samples in order (Gammell et al. 2015)",
        _range,
    ),
    "ompl_bit_star": Kind(
        "BITstar",
        OptimalOptions,
        "batches of samples searched in order of length (Gammell et al. 2015)",
        _nothing,
    ),
    "ompl_fmt": Kind(
        "FMT", BatchOptions, "one batch of samples, marched through (Janson et al. 2015)", _samples
    ),
    "ompl_bfmt": Kind("BFMT", BatchOptions, "FMT from both ends", _samples),
}
"""By the name recipes use. PRM, PRM* and AORRTC do not come back from Python: docs/planners.md."""
