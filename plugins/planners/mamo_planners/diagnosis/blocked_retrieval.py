"""Why the target cannot be taken out, not even without the movables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mamo_core.interfaces.retrieval import RetrievalPlanner
from mamo_core.types.problem import Problem
from mamo_core.types.scene import Mobility
from mamo_core.types.solution import Statistics
from mamo_planners.diagnosis.sparing import indispensable

_SEED = 0


def count_what_blocks(
    problem: Problem, retrieval: RetrievalPlanner, statistics: Statistics
) -> None:
    """Immovables and fixtures without which there is a retrieval, none of which can be spared.

    They are involved in the cause ``blocked`` of the target. Where there is none even in an empty
    scene, its own causes are counted instead: the grasps are wrong, or the arm. So are those of
    the scene as it is, if the planner cannot do without anything.
    """
    target = problem.scene.objects[problem.scene.target_index].name
    bodies = _far_ones_first(problem)
    empty = retrieval.without(bodies) or retrieval
    causes = _why_not(problem, empty)
    if causes is None:
        blocking = indispensable(bodies, lambda gone: _retrieved(problem, retrieval, gone))
        statistics.failed(target, "retrieval", "blocked", int(bool(blocking)), blocking or ())
        return
    for cause, times in causes.items() or [("no_grasps", 1)]:
        statistics.failed(target, "retrieval", cause, times)


def _retrieved(problem: Problem, retrieval: RetrievalPlanner, gone: Sequence[str]) -> bool:
    planner = retrieval.without(gone)
    return planner is not None and _why_not(problem, planner) is None


def _why_not(problem: Problem, planner: RetrievalPlanner) -> Mapping[str, int] | None:
    """Why there is no retrieval without the movables; None if there is one."""
    rng = np.random.default_rng(_SEED)
    found = planner.plan(problem.initial, rng, ignore_movables=True)
    return found.causes if found.motion is None else None


def _far_ones_first(problem: Problem) -> list[str]:
    """Fixtures, then immovables, the farthest from the target first: what is blamed is near."""
    scene, poses = problem.scene, problem.initial.object_poses
    places = [i for i, o in enumerate(scene.objects) if o.mobility is Mobility.IMMOVABLE]
    away = np.linalg.norm(poses[:, :2] - poses[scene.target_index, :2], axis=1)
    places.sort(key=lambda i: -away[i])
    return [*(f.name for f in scene.fixtures), *(scene.objects[i].name for i in places)]
