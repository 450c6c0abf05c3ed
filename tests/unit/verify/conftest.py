"""A small shelf with one movable in the way, and a plan for it, made once."""

from dataclasses import replace

import numpy as np
import pytest

from mamo_core.compose import compose
from mamo_core.plugins import discover
from mamo_core.problems import generate_shelf
from mamo_core.problems.documents import automatic_grasps
from mamo_core.recipes import find_recipe, load_recipe
from mamo_core.types.geometry import Box, Cylinder, make_pose
from mamo_core.types.scene import Mobility, SceneObject, SceneState
from mamo_core.types.solution import SolutionStatus


def small_problem():
    """A wide box right in front of the target, a post and a box beside."""
    empty = generate_shelf(movables=0, seed=1)
    floor = empty.scene.workspace.floor
    things = [
        ("blocker", Box(np.array([0.07, 0.12, 0.2])), Mobility.MOVABLE, (0.58, -0.5)),
        ("beside", Box(np.array([0.06, 0.06, 0.18])), Mobility.MOVABLE, (0.9, -0.8)),
        ("post", Cylinder(0.03, 0.2), Mobility.IMMOVABLE, (0.9, -0.2)),
        ("target", Cylinder(0.03, 0.16), Mobility.TARGET, (0.7, -0.5)),
    ]
    objects = tuple(SceneObject(name, shape, kind, 0.2, 1.0) for name, shape, kind, _ in things)
    poses = [make_pose([*xy, floor + shape.height / 2.0]) for _, shape, _, xy in things]
    scene = replace(empty.scene, objects=objects)
    initial = SceneState(empty.home, np.array(poses))
    grasps = automatic_grasps(scene, poses[-1])
    return replace(empty, name="small", scene=scene, initial=initial, grasps=grasps)


@pytest.fixture(scope="session")
def problem():
    return small_problem()


@pytest.fixture(scope="session")
def planner(problem):
    return compose(load_recipe(find_recipe("m4m")), problem, discover())


@pytest.fixture(scope="session")
def plan(planner):
    solution = planner.solve(60.0, seed=0)
    assert solution.status is SolutionStatus.SOLVED, solution.reason
    assert solution.plan.actions, "nothing had to be moved: the tests need an action"
    return solution.plan
