"""Whether an arm passes everything by, with what it holds: then nothing need be simulated."""

from __future__ import annotations

from collections.abc import Sequence

from mamo_core.interfaces.collision_checker import CollisionChecker, HeldObject
from mamo_core.robots.exact_collision import ExactWorld
from mamo_core.robots.kinematics import tool_transform
from mamo_core.robots.model import ArmModel
from mamo_core.robots.timing import sampled
from mamo_core.types.geometry import matrix_from_pose
from mamo_core.types.motion import MotionSegment
from mamo_core.types.scene import Scene, SceneState

_STEP = 0.05


def passes(
    checker: CollisionChecker,
    scene: Scene,
    robot: ArmModel,
    segments: Sequence[MotionSegment],
    state: SceneState,
    opening: float,
) -> bool:
    """Whether contact-free ``segments`` touch nothing with the objects at rest in ``state``.

    What they hold stands in ``state`` where the first of them takes it along. ``opening`` (m): the
    gripper's before.
    """
    before = opening
    held = _held(scene, robot, segments, state)
    for segment in segments:
        rows = sampled(segment.trajectory, _STEP)
        carried = held if segment.held is not None else None
        ignore = [segment.held] if segment.held is not None else []
        # The fingers move during a segment: both ends of their way are checked.
        for width in {before, segment.opening}:
            world = checker.world(state.object_poses, opening=width, ignore=ignore, held=carried)
            # Whether the arm meets itself does not depend on the world, and is asked elsewhere.
            if isinstance(world, ExactWorld):
                if world.first_touched(rows) is not None:
                    return False
            elif not world.free(rows).all():
                return False
        before = segment.opening
    return True


def _held(
    scene: Scene, robot: ArmModel, segments: Sequence[MotionSegment], state: SceneState
) -> HeldObject | None:
    """What the first segment that holds something takes along."""
    first = next((segment for segment in segments if segment.held is not None), None)
    if first is None or first.held is None:
        return None
    number = scene.index(first.held)
    T_world_base = matrix_from_pose(scene.T_world_base)
    T_world_tool = T_world_base @ tool_transform(robot, first.trajectory.positions[0])
    T_world_object = matrix_from_pose(state.object_poses[number])
    shape = scene.objects[number].shape
    return HeldObject.taken(first.held, shape, T_world_tool, T_world_object)
