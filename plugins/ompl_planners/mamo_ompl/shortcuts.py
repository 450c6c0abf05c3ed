"""Shorter paths by straight motions between places of the path."""

from __future__ import annotations

import numpy as np

from mamo_core.types.geometry import Array
from mamo_ompl.work import Work


def shortened(path: Array, work: Work, rng: np.random.Generator, tries: int) -> Array:
    """The path (k, dof) with stretches replaced by free straight motions, or as it is.

    The straight way from end to end is tried first, then ``tries`` pairs of random places. OMPL's
    own simplifier is not used: it stops by the clock.
    """
    if tries and len(path) > 2 and work.edge_free(path[0], path[-1]):
        return path[[0, -1]]
    for _ in range(tries):
        if len(path) < 3:
            break
        u, v = np.sort(rng.random(2)) * (len(path) - 1)
        i, j = (min(int(w), len(path) - 2) for w in (u, v))
        if i == j:
            continue
        cut = np.stack([path[i], _place(path, u), _place(path, v), path[j + 1]])
        # The new motion first. Its ends need a look, too: checkers step along a motion from its
        # start, and may find half of a free motion blocked where it is tight.
        if all(work.edge_free(cut[k], cut[k + 1]) for k in (1, 0, 2)):
            path = np.vstack([path[:i], cut, path[j + 2 :]])
    return path


def _place(path: Array, u: float) -> Array:
    """The configuration at ``u``, in corners from the start."""
    i = min(int(u), len(path) - 2)
    return path[i] + (u - i) * (path[i + 1] - path[i])
