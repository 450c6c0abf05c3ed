"""Options of the searches, apart from the code that uses them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import Field

from mamo_core.hookspecs import Options

_FITTED = "fitted by: mamo learn-priority --problems 60"

_NEARBY = (
    "actions and retrievals must hold, with some room, in the worlds close to the problem's that "
    "verification asks: objects moved by 0.1 mm, finer steps; thesis: null"
)


class Room(Options):
    """What is kept from the limits where something must hold in several worlds."""

    limit_share: float = Field(
        1.0,
        gt=0.0,
        le=1.0,
        description="share of the limits of tilt, speed and penetration that may be reached; "
        "thesis: 1",
    )
    clearance: float = Field(
        0.0,
        ge=0.0,
        description="distance that movable objects keep at all times from what must not be "
        "touched, m; thesis: 0",
    )


class GreedyOptions(Options):
    """Options of ``greedy`` (M4M)."""

    nearby: Nearby | None = Field(None, description=_NEARBY)
    iterate: bool = Field(True, description="solve the MAPF problem again after every valid push")
    regions: int = Field(
        4, ge=1, description="retrievals drawn for the NGR; the least occupied one is taken"
    )
    grasp_tries: int = Field(3, ge=1, description="retrievals tried at one state")
    rounds: int = Field(6, ge=1, description="MAPF calls at one state without a valid push")
    agnostic: int = Field(
        8, ge=0, description="goal-agnostic pushes tried per state when guided ones fail"
    )
    max_actions: int = Field(25, ge=1, description="actions of one attempt")
    attempts: int = Field(1000, ge=1, description="restarts from the initial scene")
    hopeless_attempts: int = Field(
        6, ge=1, description="attempts without any retrieval, movables ignored, before giving up"
    )
    goal_margin: float = Field(0.015, ge=0.0, description="distance of MAPF goals to the NGR, m")
    mapf_nodes: int = Field(300, ge=1, description="high-level nodes per MAPF call")
    mapf_expansions: int = Field(60_000, ge=1, description="low-level expansions per MAPF call")

    def needs(self) -> Mapping[str, frozenset[str]]:
        return _needs_of(self.nearby)


class Nearby(Room):
    """The worlds close to the problem's, and others farther from it."""

    worlds: int = Field(0, ge=0, description="more worlds in which everything must hold")
    deviation: float = Field(
        0.001, ge=0.0, description="how far objects stand elsewhere in these, m"
    )
    deviation_deg: float = Field(0.5, ge=0.0, description="and how far they are turned, degrees")


def _needs_of(*rooms: Room | None) -> Mapping[str, frozenset[str]]:
    clear = any(room is not None and room.clearance > 0.0 for room in rooms)
    return {"backend": frozenset({"clearance"} if clear else ())}


class Uncertainty(Room):
    """Masses and frictions are sampled around the problem's own (thesis 6.3.4).

    The search knows the samples alone; it plans from what happens in the first one.
    """

    simulators: int = Field(6, ge=1, description="the thesis' N")
    copies: int = Field(2, ge=1, description="the thesis' M; N x M simulations are made")
    threshold: float = Field(
        0.9, gt=0.0, le=1.0, description="share of the simulations that must hold, from the start"
    )
    mass_spread: float = Field(0.2, ge=0.0, description="standard deviation of a mass, as a share")
    friction_spread: float = Field(
        0.5, ge=0.0, description="standard deviation of a friction coefficient, as a share"
    )
    stratified: bool = Field(
        False,
        description="every mass and friction has one sample in each of as many equally likely "
        "parts of its range as there are samples; thesis: all are drawn alone",
    )
    safety_margin: float = Field(
        0.0,
        ge=0.0,
        description="distance that moved objects keep from what must not be touched, in every "
        "simulation that is to hold, m; thesis: 0",
    )
    backend: dict[str, Any] = Field(
        default_factory=dict,
        description="options of the backend that are others in samples, such as a longer time_step;"
        " what the first one holds is executed with the recipe's own; thesis: none",
    )

    @property
    def samples(self) -> int:
        """Number of simulations of an action."""
        return self.simulators * self.copies


class GraphOptions(Options):
    """Options of all searches over a graph of rearrangements."""

    uncertainty: Uncertainty | None = Field(
        None, description="sampled masses and frictions instead of the problem's (6.3.4)"
    )
    nearby: Nearby | None = Field(None, description=_NEARBY)
    lazy: bool = Field(False, description="evaluate actions only when they come first (6.3.3)")
    positive_database: bool = Field(True, description="use valid pushes again (5.5.2)")
    negative_database: bool = Field(True, description="avoid goals near failed ones (5.5.1)")
    penalty: float = Field(
        6.0, gt=0.0, description="cost of a goal within 1 cm of a failed one, in lattice steps"
    )
    shared_penalty: float = Field(
        0.5, ge=0.0, description="times that, for goals that failed at another rearrangement"
    )
    forbidden_radius: float = Field(
        0.03, gt=0.0, description="goals this close to one that was tried are forbidden, m"
    )
    agnostic: int = Field(
        8, ge=0, description="goal-agnostic actions per rearrangement MAPF has no more ideas for"
    )
    costs: dict[str, float] = Field(
        default_factory=lambda: {"push": 1.0, "pick_place": 2.0, "turn": 3.0},
        description="by kind of action: cheaper ones are evaluated first",
    )
    regions: int = Field(
        1000, ge=1, description="NGRs searched one after the other (the thesis: 1; 7.1.1)"
    )
    improve: int = Field(
        0,
        ge=0,
        description="NGRs searched for a plan with fewer actions after each that was found; "
        "the best one is returned at the latest when the budget ends",
    )
    hopeless_regions: int = Field(
        25, ge=1, description="NGRs without any retrieval, movables ignored, before giving up"
    )
    draws: int = Field(
        4, ge=1, description="retrievals drawn for the first NGR, the emptiest one is taken; then 1"
    )
    expansions: int = Field(4, ge=1, description="MAPF calls at one rearrangement")
    thorough_after: int = Field(
        1, ge=0, description="NGRs searched before retrieval looks at all grasps of the problem"
    )
    visits: int = Field(
        15, ge=1, description="expansions under the first NGR; n times as many under the n-th"
    )
    patience: dict[str, int] = Field(
        default_factory=lambda: {"pick_place": 2, "turn": 1},
        description="by kind of action: failures for an object at one rearrangement before it is "
        "left out there (kinds that are not named: never)",
    )
    grasp_tries: int = Field(3, ge=1, description="retrievals tried at one rearrangement")
    max_actions: int = Field(25, ge=1, description="actions of a plan")
    goal_margin: float = Field(0.015, ge=0.0, description="distance of MAPF goals to the NGR, m")
    mapf_nodes: int = Field(300, ge=1, description="high-level nodes per MAPF call")
    mapf_expansions: int = Field(60_000, ge=1, description="low-level expansions per MAPF call")

    def needs(self) -> Mapping[str, frozenset[str]]:
        return _needs_of(self.uncertainty, self.nearby)


class DepthFirstOptions(GraphOptions):
    """Options of ``depth_first`` (I-M4M)."""


class BestFirstOptions(GraphOptions):
    """Options of ``best_first`` (E-M4M).

    The parameters of the learned priority are those that ``mamo learn-priority --problems 60``
    fits (docs/results/priority.md); the ``em4m`` recipes have those of the thesis author's code.
    """

    order: Literal["learned", "tiebreak", "breadth_first"] = Field(
        "learned", description="learned priority, its features in turn, or fewest actions"
    )
    density: Literal["survival", "thesis"] = Field(
        "survival", description="survival: never rises with an object more; thesis: densities"
    )
    alpha: float = Field(
        0.397527,
        gt=0.0,
        description=f"Beta of the NGR's occupied share ({_FITTED}; thesis: 0.3403101839)",
    )
    beta: float = Field(
        10.7174,
        gt=0.0,
        description=f"Beta of the NGR's occupied share ({_FITTED}; thesis: 45.0750087432)",
    )
    count_rate: float = Field(
        0.876652,
        gt=0.0,
        description=f"per object in the NGR ({_FITTED}; thesis: 1.5634743875)",
    )
    effort_rate: float = Field(
        7.93782,
        gt=0.0,
        description=f"per kg x friction x share in the NGR ({_FITTED}; thesis: 32.1092604858)",
    )
