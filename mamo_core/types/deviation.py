"""How far a world may be from what its problem says, and worlds that are so far from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mamo_core.types.geometry import Array
from mamo_core.types.problem import Problem
from mamo_core.types.rollout import ParameterOverrides
from mamo_core.types.scene import SceneState


@dataclass(frozen=True)
class Deviation:
    """The largest errors of a description.

    ``position`` (m) and ``angle`` (rad) of every object in the plane it stands on; ``parameters``:
    share of its mass and of its friction coefficient.
    """

    position: float
    angle: float
    parameters: float = 0.0


NEAR = Deviation(position=1e-4, angle=float(np.radians(0.05)))
"""What no sensor sees: a plan that breaks by so little was found by luck."""

NEIGHBOURS = 8
_SEED = 0


def neighbours(problem: Problem) -> tuple[SceneState, ...]:
    """The starts a hair's breadth away (``NEAR``) from which every plan must hold, too."""
    rng = np.random.default_rng(_SEED)
    initial = problem.initial
    return tuple(
        SceneState(initial.joint_positions, moved(initial.object_poses, NEAR, rng))
        for _ in range(NEIGHBOURS)
    )


def moved(poses: Array, deviation: Deviation, rng: np.random.Generator) -> Array:
    """``poses`` (n, 7), each moved within a disc and turned about the vertical, evenly drawn."""
    count = len(poses)
    lengths = deviation.position * np.sqrt(rng.random(count))
    headings = rng.uniform(-np.pi, np.pi, count)
    turns = rng.uniform(-deviation.angle, deviation.angle, count)
    found = np.array(poses)
    found[:, 0] += lengths * np.cos(headings)
    found[:, 1] += lengths * np.sin(headings)
    found[:, 3:] = turned(poses[:, 3:], turns)
    return found


def turned(quats_wxyz: Array, angles: Array) -> Array:
    """Quaternions (n, 4) turned about the world's z axis by ``angles`` (n,), rad."""
    c, s = np.cos(angles / 2.0), np.sin(angles / 2.0)
    w, x, y, z = quats_wxyz.T
    return np.stack([c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w], axis=1)


def other_parameters(
    problem: Problem, deviation: Deviation, rng: np.random.Generator
) -> ParameterOverrides | None:
    """Masses and frictions, each evenly drawn about the problem's own; None if they are known."""
    if deviation.parameters == 0.0:
        return None
    objects = problem.scene.objects
    shares = 1.0 + deviation.parameters * rng.uniform(-1.0, 1.0, (len(objects), 2))
    return ParameterOverrides(
        {item.name: item.mass * share for item, share in zip(objects, shares[:, 0], strict=True)},
        {
            item.name: item.friction * share
            for item, share in zip(objects, shares[:, 1], strict=True)
        },
    )
