"""Actions that only carry: masses and frictions do not matter to what nothing else touches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mamo_core.types.action import RearrangementAction
from mamo_core.types.motion import SegmentKind
from mamo_core.types.rollout import RolloutResult
from mamo_core.types.scene import Scene, SceneState

_SAME = 1e-3
"""An object stands as in the first engine up to this, m (and as much of a quaternion)."""


def carried(
    scene: Scene, action: RearrangementAction, leader: RolloutResult, state: SceneState
) -> RolloutResult | None:
    """What an action does to a scene in ``state`` if it does to its object what the ``leader`` saw.

    None if it may do something else: it pushes, something but its object was touched, or the object
    stands elsewhere here. Whether the way is free among the other objects is not looked at.
    """
    name, number = action.object_name, scene.index(action.object_name)
    others = {item.name for item in scene.objects} - {name}
    only_carries = all(
        segment.held == name or segment.contact_free or segment.kind is SegmentKind.GRIPPER
        for segment in action.motion.segments
    )
    if not only_carries or any(others & set(pair) for pair in leader.contacts):
        return None
    begin = leader.segment_states[0].object_poses[number]
    if np.abs(state.object_poses[number] - begin).max() > _SAME:
        return None

    def here(there: SceneState) -> SceneState:
        poses = np.array(state.object_poses)
        poses[number] = there.object_poses[number]
        return SceneState(there.joint_positions, poses)

    return replace(
        leader,
        final_state=here(leader.final_state),
        segment_states=tuple(here(there) for there in leader.segment_states),
        continuation=None,
    )
