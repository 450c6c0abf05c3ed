"""From a pre-grasp on: grasp the target and carry it home."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mamo_core.types.geometry import Array
from mamo_core.types.motion import MotionSegment
from mamo_core.types.scene import SceneState
from mamo_planners.grasp_candidates import Candidate
from mamo_planners.options import RetrievalOptions
from mamo_planners.retrieval_motion import RetrievalMotion

if TYPE_CHECKING:
    from mamo_planners.reaching.stand import ReachingParts


def carried_home(
    parts: ReachingParts,
    state: SceneState,
    way: Array,
    candidate: Candidate,
    rng: np.random.Generator,
) -> tuple[MotionSegment, ...]:
    """Reach, lift and carry, which keeps clear of everything or goes back the ``way`` (k, dof).

    What comes back may push objects; only the engine can tell whether it does so validly.
    """
    problem = parts.problem
    target = problem.scene.objects[problem.scene.target_index].name
    motion = RetrievalMotion(problem, parts.arm, parts.kinematics, RetrievalOptions())
    world = parts.collision.world(
        state.object_poses, opening=candidate.width, ignore=[target], held=candidate.held
    )
    goal = problem.home[None, :]
    carry = parts.arm_planner.plan(candidate.lift[-1], goal, world, rng).path
    clear = carry is not None
    path = carry if carry is not None else np.vstack([candidate.lift[-1:], way[::-1]])
    return motion.taken_out(candidate, path, contact_free=clear)
