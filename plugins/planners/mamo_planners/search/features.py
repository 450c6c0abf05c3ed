"""What a rearrangement looks like to the priority function (thesis 5.5.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mamo_core.types.problem import Problem
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import SceneState


@dataclass(frozen=True)
class Features:
    """How hard it is to clear the region.

    ``occupied``: share (0..1) of the region's area that movables stand in. ``count``: how many.
    ``efforts``: of each of those mass (kg) x friction x share of its footprint inside.
    """

    occupied: float
    count: int
    efforts: tuple[float, ...]


def features_of(problem: Problem, state: SceneState, region: SweptRegion) -> Features:
    """Of the movables of a state and the region.

    The thesis takes shares of volume; the region is a height map here, so they are of area.
    """
    scene = problem.scene
    taken = np.zeros(region.lowest.shape, dtype=np.bool_)
    efforts = []
    for i in scene.movable_indices:
        item, pose = scene.objects[i], state.object_poses[i]
        footprint = region.touched_cells(item.shape, pose)
        top = float(pose[2]) + item.shape.height / 2.0
        inside = footprint & region.swept_under(top)
        if inside.any():
            taken |= inside
            share = float(inside.sum()) / float(footprint.sum())
            efforts.append(item.mass * item.friction * share)
    swept = region.swept_under(float(scene.workspace.upper[2]))
    occupied = float(taken.sum()) / max(1.0, float(swept.sum()))
    return Features(occupied, len(efforts), tuple(efforts))
