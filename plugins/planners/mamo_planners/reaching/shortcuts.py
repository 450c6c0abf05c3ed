"""Paths of many small primitives, straightened."""

from __future__ import annotations

import numpy as np

from mamo_core.interfaces.collision_checker import CollisionWorld
from mamo_core.types.geometry import Array


def straightened(path: Array, world: CollisionWorld) -> Array:
    """The path (k, dof) with straight motions in place of stretches that they can replace.

    From each configuration the last one that a free straight motion leads to comes next.
    """
    kept, place = [0], 0
    while place < len(path) - 1:
        ahead = path[place + 1 :]
        free = world.edges_free(np.repeat(path[place : place + 1], len(ahead), axis=0), ahead)
        # The next one is connected already, whatever the checker's resolution says of it.
        place += 1 + int(np.flatnonzero(free).max(initial=0))
        kept.append(place)
    return path[kept]
