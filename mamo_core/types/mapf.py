"""The abstract problem: standing objects as agents that walk out of the NGR (thesis 4.4.1)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from mamo_core.types.geometry import Array, Shape, frozen_array
from mamo_core.types.region import SweptRegion


@dataclass(frozen=True, eq=False)
class GoalPenalty:
    """Ending within ``radius`` (m) of ``position`` (2,) costs ``cost`` more; inf forbids it."""

    position: Array
    radius: float
    cost: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", frozen_array(self.position, "penalty", (2,)))


@dataclass(frozen=True, eq=False)
class CostField:
    """Extra cost (>= 0, per step) of being over a cell; outside the field nothing is added.

    ``values`` (nx, ny); cell (i, j) covers ``origin + [i, i+1] x [j, j+1] * resolution``, metres.
    """

    origin: Array
    resolution: float
    values: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", frozen_array(self.origin, "cost field", (2,)))
        values = frozen_array(self.values, "cost field values", (None, None))
        if (values < 0.0).any():
            raise ValueError(f"cost field: values must not be negative, lowest is {values.min()}")
        object.__setattr__(self, "values", values)


@dataclass(frozen=True, eq=False)
class MAPFAgent:
    """A movable object: ``shape`` standing at ``pose`` (7,), world; yaw never changes."""

    name: str
    shape: Shape
    pose: Array
    penalties: tuple[GoalPenalty, ...] = ()
    cost_field: CostField | None = None


@dataclass(frozen=True, eq=False)
class MAPFObstacle:
    """Something no agent may overlap: ``shape`` at ``pose`` (7,), world."""

    name: str
    shape: Shape
    pose: Array


@dataclass(frozen=True, eq=False)
class MAPFProblem:
    """Move agents, a lattice step of ``resolution`` m or a wait each, until none is in ``region``.

    The lattice of an agent is anchored at its start pose. Every footprint stays within
    ``transit_lower``..``transit_upper`` (2,) always and within ``goal_lower``..``goal_upper`` at
    its goal (an agent that never moves is exempt, from ``goal_margin``, too). ``margin`` (m) is
    kept from obstacles and other agents, ``goal_margin`` from the region at goals. What is closer
    than that at the start, or out of bounds, may stay so but comes no closer, and no further out.
    A move costs 1 plus the cost field where it arrives; a wait away from the final goal costs
    ``wait_cost`` (0 < wait_cost <= 1).
    """

    agents: tuple[MAPFAgent, ...]
    obstacles: tuple[MAPFObstacle, ...]
    region: SweptRegion
    transit_lower: Array
    transit_upper: Array
    goal_lower: Array
    goal_upper: Array
    resolution: float = 0.01
    margin: float = 0.0
    goal_margin: float = 0.0
    wait_cost: float = 1.0

    def __post_init__(self) -> None:
        for name in ("transit_lower", "transit_upper", "goal_lower", "goal_upper"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), name, (2,)))


@dataclass(frozen=True)
class MAPFBudget:
    """Work allowed: high-level nodes, and low-level expansions in all."""

    nodes: int = 2_000
    expansions: int = 2_000_000


class MAPFStatus(StrEnum):
    """What a MAPF solver can say; TIMEOUT means that its work ran out."""

    OPTIMAL = "optimal"
    BOUNDED = "bounded"
    FEASIBLE = "feasible"
    INFEASIBLE = "infeasible"
    TIMEOUT = "timeout"


@dataclass(frozen=True, eq=False)
class MAPFSolution:
    """Paths by agent name: world xy (T + 1, 2) per time step; agents that stay have one row.

    ``cost`` in lattice steps, goal penalties included; ``lower_bound`` on the optimum;
    ``bound``: cost <= bound * optimum (1 if OPTIMAL). ``blame``: for INFEASIBLE, agent -> reason.
    """

    status: MAPFStatus
    paths: Mapping[str, Array] = field(default_factory=dict)
    cost: float = float("inf")
    lower_bound: float = 0.0
    bound: float = float("inf")
    blame: Mapping[str, str] = field(default_factory=dict)
    nodes: int = 0
    expansions: int = 0

    @property
    def solved(self) -> bool:
        """Whether there are paths."""
        return self.status in (MAPFStatus.OPTIMAL, MAPFStatus.BOUNDED, MAPFStatus.FEASIBLE)
