"""Goals that MAPF should not propose again, and places near them (thesis 5.4.1, 5.5.1)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mamo_core.types.geometry import Array
from mamo_core.types.mapf import GoalPenalty
from mamo_core.types.scene import Scene
from mamo_planners.search.likeness import SAME_PLACE
from mamo_planners.search.run import Penalties
from mamo_planners.search.vertices import Aim, Vertex

_CELL = 0.01


@dataclass(frozen=True)
class GoalMemory:
    """How failures steer MAPF.

    ``radius`` (m): goals this close to one that was tried here are forbidden. ``weight``: cost, in
    lattice steps, of a goal within a cell of a failed one; half of it within two, a third within
    three; 0 for none. ``shared``: times that, for what failed elsewhere with the object at the
    same place.
    """

    radius: float
    weight: float
    shared: float


@dataclass(frozen=True, eq=False)
class Failure:
    """An object at ``start`` (2,) could not be brought to ``goal`` (2,), world."""

    name: str
    start: Array
    goal: Array


class GoalPenalties:
    """What MAPF is told of goals. A goal is told of in every later call, so penalties are kept."""

    def __init__(self, scene: Scene, memory: GoalMemory) -> None:
        self._scene, self._memory = scene, memory
        self._rings: dict[tuple[float, float, float], tuple[GoalPenalty, ...]] = {}

    def of(self, vertex: Vertex, failures: list[Failure]) -> Penalties | None:
        """What the next MAPF call from here is told; None if that would be nothing new.

        Only once there is nothing new that failed, the other aims are "hallucinated" as failed.
        """
        failed = [aim for aim in vertex.aims if aim.failed]
        others = [aim for aim in vertex.aims if not aim.failed]
        if vertex.expansions and len(failed) <= vertex.known:
            if len(others) <= vertex.hallucinated:
                return None
            vertex.hallucinated = len(others)
        vertex.known = len(failed)
        made: dict[str, list[GoalPenalty]] = defaultdict(list)
        for aim in [*failed, *(others if vertex.hallucinated else ())]:
            made[aim.name].append(GoalPenalty(aim.goal, self._memory.radius, float("inf")))
        for name, penalty in self._nearby(vertex, failed, failures):
            made[name].append(penalty)
        return made

    def _nearby(
        self, vertex: Vertex, failed: list[Aim], failures: list[Failure]
    ) -> Iterator[tuple[str, GoalPenalty]]:
        memory = self._memory
        if not memory.weight:
            return
        for aim in failed:
            yield from ((aim.name, ring) for ring in self._around(aim.goal, memory.weight))
        for failure in failures if memory.shared else ():
            if vertex.has_aim(failure.name, failure.goal):
                continue
            here = vertex.state.object_poses[self._scene.index(failure.name), :2]
            if np.linalg.norm(here - failure.start) <= SAME_PLACE:
                rings = self._around(failure.goal, memory.weight * memory.shared)
                yield from ((failure.name, ring) for ring in rings)

    def _around(self, place: Array, weight: float) -> tuple[GoalPenalty, ...]:
        """Costs add up to 1 within a cell, 1/2 within two and 1/3 within three."""
        key = (float(place[0]), float(place[1]), weight)
        if key not in self._rings:
            self._rings[key] = tuple(
                GoalPenalty(place, cells * _CELL, weight * share)
                for cells, share in ((1, 1.0 / 2.0), (2, 1.0 / 6.0), (3, 1.0 / 3.0))
            )
        return self._rings[key]
