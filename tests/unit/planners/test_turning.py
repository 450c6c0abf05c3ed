"""What pushes beside the centre do in an engine: a wide box gets out of the way by turning."""

from dataclasses import replace

import numpy as np

from mamo_core.compose import compose
from mamo_core.interfaces.action_generator import ActionRequest
from mamo_core.plugins import discover
from mamo_core.problems import generate_shelf
from mamo_core.recipe_sets import chosen_recipe
from mamo_core.types.geometry import Box, Cylinder, make_pose, yaw_of
from mamo_core.types.region import SweptRegion
from mamo_core.types.scene import Mobility, SceneObject, SceneState
from mamo_core.types.solution import Statistics

WIDE = Box(np.array([0.1, 0.16, 0.2]))


def beside_the_wall():
    """A box 3 cm from the right wall, the target far from it."""
    empty = generate_shelf(movables=0, seed=1)
    target = Cylinder(0.03, 0.16)
    objects = (
        SceneObject("wide", WIDE, Mobility.MOVABLE, 0.3, 1.0),
        SceneObject("target", target, Mobility.TARGET, 0.2, 1.0),
    )
    floor = empty.scene.workspace.floor
    poses = [make_pose([0.6, -0.79, floor + 0.1]), make_pose([0.8, -0.3, floor + 0.08])]
    scene = replace(empty.scene, objects=objects)
    return replace(empty, scene=scene, initial=SceneState(empty.home, np.array(poses)), grasps=())


def region():
    """All to the left of a line that leaves 14 cm beside the wall: the box is 16 cm wide."""
    lowest = np.full((80, 60), 0.8)
    return SweptRegion(np.array([0.4, -0.76]), 0.01, lowest, 0.77)


def test_a_wide_box_is_turned_out_of_the_way():
    problem, swept = beside_the_wall(), region()
    context = compose(chosen_recipe("default"), problem, discover()).context
    turn, model = dict(context.actions)["turn"], context.part("backend")
    request, rng = ActionRequest("wide", None, swept), np.random.default_rng(0)
    state = problem.initial
    assert swept.overlaps(WIDE, state.object_poses[0])
    for _ in range(8):
        accepts = turn.progress(state, request)
        for action in turn.propose(state, request, rng, Statistics()):
            motion = action.motion.after_transit()
            result = model.rollout(state.with_joints(motion.start), motion)
            if result.valid and accepts(result.final_state):
                state = result.final_state.with_joints(motion.end)
                break
        if not swept.overlaps(WIDE, state.object_poses[0]):
            break
    assert not swept.overlaps(WIDE, state.object_poses[0])
    assert abs(np.sin(yaw_of(state.object_poses[0]))) > 0.7
