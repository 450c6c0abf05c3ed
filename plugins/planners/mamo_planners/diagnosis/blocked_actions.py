"""What keeps the arm from even trying to move an object."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mamo_core.interfaces.action_generator import ActionGenerator, ActionRequest
from mamo_core.types.problem import Problem
from mamo_core.types.scene import Mobility
from mamo_core.types.solution import Statistics
from mamo_planners.diagnosis.sparing import indispensable

_SEED = 0


def count_what_blocks(
    problem: Problem,
    kind: str,
    generator: ActionGenerator,
    request: ActionRequest,
    statistics: Statistics,
) -> None:
    """Other objects without which the generator has a proposal, none of which can be spared.

    They are involved in the cause ``blocked`` of the object. Nothing is counted if it has one with
    all of them, or not even without: then the shelf is too narrow, or the arm.
    """
    if _proposes(problem, generator, request):
        return

    def opens(gone: Sequence[str]) -> bool:
        other = generator.without(gone)
        return other is not None and _proposes(problem, other, request)

    blocking = indispensable(_others(problem, request.object_name), opens)
    if blocking:
        statistics.failed(request.object_name, kind, "blocked", involved=blocking)


def _proposes(problem: Problem, generator: ActionGenerator, request: ActionRequest) -> bool:
    rng = np.random.default_rng(_SEED)
    proposals = generator.propose(problem.initial, request, rng, Statistics())
    return next(proposals, None) is not None


def _others(problem: Problem, name: str) -> list[str]:
    """What cannot be moved, then movables, the farthest from the object first."""
    scene, poses = problem.scene, problem.initial.object_poses
    away = np.linalg.norm(poses[:, :2] - poses[scene.index(name), :2], axis=1)
    places = [i for i, item in enumerate(scene.objects) if item.name != name]
    places.sort(key=lambda i: (scene.objects[i].mobility is Mobility.MOVABLE, -away[i]))
    return [scene.objects[i].name for i in places]
