"""Problems for the tests: small ones by hand or at random, and the published scenes."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from mamo_core.problems.published import scenes_folder
from mamo_core.types.geometry import Array, Box, Cylinder, Shape, make_pose
from mamo_core.types.mapf import MAPFAgent, MAPFObstacle, MAPFProblem
from mamo_core.types.region import SweptRegion

FLOOR = 0.77
REGION_RESOLUTION = 0.01


def load_scenes(movables: int) -> list[dict[str, Any]]:
    """The scenes with that many movables."""
    folder = scenes_folder()
    if not folder.is_dir():
        pytest.skip("no published scenes: set MAMO_SCENES or provide ../shared/scenes")
    with gzip.open(folder / f"thesis_{movables}_movables.jsonl.gz", "rt") as file:
        return [json.loads(line) for line in file]


def shape_of(body: dict[str, Any]) -> Shape:
    if body["shape"] == "box":
        return Box(np.array(body["size"]))
    return Cylinder(body["radius"], body["height"])


def arm_region(scene: dict[str, Any]) -> SweptRegion:
    """What an arm might sweep: a corridor 0.24 m wide along the grasp, wider towards the front."""
    yaw = scene["pregrasp"]["yaw"]
    along = np.array([np.cos(yaw), np.sin(yaw)])
    target = np.array(scene["ooi"]["pos"][:2])
    origin = np.array([0.40, -0.95])
    x = origin[0] + (np.arange(75) + 0.5) * REGION_RESOLUTION
    y = origin[1] + (np.arange(90) + 0.5) * REGION_RESOLUTION
    dx, dy = x[:, None] - target[0], y[None, :] - target[1]
    behind = -(dx * along[0] + dy * along[1])
    aside = np.abs(-dx * along[1] + dy * along[0])
    half = 0.12 + 0.10 * np.clip(behind - 0.20, 0.0, None)
    swept = (behind > -0.06) & (aside < half)
    return SweptRegion(origin, REGION_RESOLUTION, np.where(swept, FLOOR + 0.02, np.inf), FLOOR)


def scene_problem(scene: dict[str, Any], **settings: Any) -> MAPFProblem:
    """The abstract problem of a published scene."""

    def pose(body: dict[str, Any]) -> Array:
        return make_pose(body["pos"], body["yaw"])

    fixed = [*scene["immovables"], scene["ooi"]]
    return MAPFProblem(
        agents=tuple(MAPFAgent(str(b["id"]), shape_of(b), pose(b)) for b in scene["movables"]),
        obstacles=tuple(MAPFObstacle(str(b["id"]), shape_of(b), pose(b)) for b in fixed),
        region=arm_region(scene),
        transit_lower=np.array([0.43, -0.90]),
        transit_upper=np.array([1.08, -0.10]),
        goal_lower=np.array([0.48, -0.90]),
        goal_upper=np.array([1.08, -0.10]),
        **settings,
    )


@pytest.fixture
def thesis_problems() -> Callable[..., list[MAPFProblem]]:
    """``(movables, count, **settings)`` -> problems of the first published scenes."""

    def build(movables: int, count: int, **settings: Any) -> list[MAPFProblem]:
        return [scene_problem(s, **settings) for s in load_scenes(movables)[:count]]

    return build
