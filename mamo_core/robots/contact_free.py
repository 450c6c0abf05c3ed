"""Contact-free segments against the exact meshes."""

from __future__ import annotations

from collections.abc import Sequence

from mamo_core.robots.exact_collision import ExactChecker
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import sampled
from mamo_core.types.motion import MotionSegment
from mamo_core.types.scene import Scene, SceneState

_MESH_STEP = 0.05


def check_meshes(
    scene: Scene,
    segments: Sequence[MotionSegment],
    states: Sequence[SceneState],
    robot: ArmModel,
    opening: float,
) -> list[str]:
    """Where contact-free segments touch something after all, in words; empty if nowhere.

    Checked are the exact meshes of the arm, with the objects where ``states`` (one for the start of
    each segment) say. ``opening`` (m): the gripper's before the first segment.
    """
    checker = ExactChecker(scene, robot)
    failures = []
    before = opening
    for segment, state in zip(segments, states, strict=True):
        # The fingers move during a segment: both ends of their way are checked.
        for width in {before, segment.opening} if segment.contact_free else ():
            ignore = [name for name in (segment.held, segment.closes_on) if name is not None]
            world = checker.world(state.object_poses, opening=width, ignore=ignore)
            rows = sampled(segment.trajectory, _MESH_STEP)
            touched = world.first_touched(rows)
            if touched is not None:
                failures.append(f"{segment.kind}: the arm's mesh touches {touched}")
                break
        before = segment.opening
    return failures
