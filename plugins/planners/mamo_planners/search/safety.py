"""A distance that objects keep from what must not be touched, where masses are not known well."""

from __future__ import annotations

from mamo_core.types.geometry import Array, Shape, footprint_corners
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import Mobility
from mamo_planners.footprints import Outlines, grown


class SafetyMargin:
    """Moved objects must end ``margin`` (m) away from immovable ones and the target, as seen from
    above; one that was closer before may stay so."""

    def __init__(self, problem: Problem, margin: float) -> None:
        objects, poses = problem.scene.objects, problem.initial.object_poses
        self._objects, self._margin = objects, margin
        self._guarded = Outlines(
            [
                footprint_corners(grown(item.shape, margin), pose)
                for item, pose in zip(objects, poses, strict=True)
                if item.mobility is not Mobility.MOVABLE
            ]
        )

    def kept(self, result: RolloutResult) -> bool:
        """Whether what a rollout moved is far enough away at its end."""
        if self._margin == 0.0:
            return True
        before, after = result.segment_states[0].object_poses, result.final_state.object_poses
        for number, item in enumerate(self._objects):
            if item.name not in result.moved or item.mobility is not Mobility.MOVABLE:
                continue
            if self._near(item.shape, after[number]) and not self._near(item.shape, before[number]):
                return False
        return True

    def _near(self, shape: Shape, pose: Array) -> bool:
        return bool(self._guarded.overlapped(footprint_corners(shape, pose)[None])[0])
