"""Retrievals that need not be executed once more, as they touch nothing but the target."""

from __future__ import annotations

from mamo_core.interfaces.collision_checker import CollisionChecker, HeldObject
from mamo_core.interfaces.kinematics import Kinematics
from mamo_core.types.geometry import matrix_from_pose
from mamo_core.types.motion import Motion, SegmentKind
from mamo_core.types.problem import Problem
from mamo_core.types.scene import SceneState


def keeps_clear(
    problem: Problem,
    kinematics: Kinematics,
    collision: CollisionChecker,
    retrieval: Motion,
    state: SceneState,
) -> bool:
    """Whether arm and target stay away from all objects of ``state``, by the planning checker.

    It is conservative: False says nothing.
    """
    number = problem.scene.target_index
    target = problem.scene.objects[number]
    first = next(s for s in retrieval.segments if s.held is not None)
    T_world_tool = kinematics.forward(first.trajectory.positions[0])
    T_world_target = matrix_from_pose(state.object_poses[number])
    held = HeldObject.taken(target.name, target.shape, T_world_tool, T_world_target)
    for segment in retrieval.segments:
        carried = held if segment.held is not None else None
        world = collision.world(
            state.object_poses, opening=segment.opening, ignore=[target.name], held=carried
        )
        rows = segment.trajectory.positions
        # The target stands on something until it is lifted.
        if not world.free(rows[-1:] if segment.kind is SegmentKind.LIFT else rows).all():
            return False
    return True
