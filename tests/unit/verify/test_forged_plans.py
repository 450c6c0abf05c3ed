"""A plan file vouches for nothing: not for itself, its engine or its world."""

import json
from dataclasses import replace

import numpy as np
import pytest

from mamo_core.choices import choose
from mamo_core.compose import build_parts
from mamo_core.config import Located
from mamo_core.errors import InputError
from mamo_core.plan_file import PlanDocument, in_problem, plan_text, read_plan_text
from mamo_core.plugins import discover
from mamo_core.recipes import load_recipe
from mamo_core.robots.kinematics import tool_transform
from mamo_core.types.geometry import Box, make_pose, matrix_from_pose
from mamo_core.types.motion import SegmentKind
from mamo_core.types.scene import Fixture, Mobility, SceneState
from mamo_core.types.solution import Plan


@pytest.fixture(scope="module")
def registry():
    return discover()


@pytest.fixture(scope="module")
def document(problem, planner, plan):
    return PlanDocument(problem, plan, planner.recipe.data, seed=0)


@pytest.fixture
def failures(registry):
    """``failures(document, problem)``: of the plan in its file; ``problem``: the user's world."""

    def check(document, problem=None):
        read = read_plan_text(plan_text(document), "plan.json")
        read = read if problem is None else in_problem(read, problem)
        recipe = load_recipe(Located(dict(read.recipe), "plan.json: recipe"))
        choices = choose(recipe, read.problem, registry, ("constraint", "backend"))
        return (
            build_parts(choices, read.problem).part("verifier")(read.plan, replays=False).failures
        )

    return check


def mentions(found, text):
    assert any(text in failure for failure in found), found


def with_segments(plan, change):
    """The plan with ``change(segment)`` for every segment of all motions."""

    def changed(motion):
        return replace(motion, segments=tuple(change(s) for s in motion.segments))

    actions = tuple(replace(a, motion=changed(a.motion)) for a in plan.actions)
    return Plan(actions, changed(plan.retrieval))


def with_fixture(problem, fixture):
    scene = replace(problem.scene, fixtures=(*problem.scene.fixtures, fixture))
    return replace(problem, scene=scene)


def with_object(problem, which, **changes):
    objects = tuple(
        replace(item, **changes) if item.name == which else item for item in problem.scene.objects
    )
    return replace(problem, scene=replace(problem.scene, objects=objects))


@pytest.fixture(scope="module")
def pillar(problem, planner, plan):
    """A thin post where the hand passes on its way to the first push."""
    way = plan.actions[0].motion.segments[0].trajectory.positions
    T_world_base = matrix_from_pose(problem.scene.T_world_base)
    tool = T_world_base @ tool_transform(planner.context.robot, way[len(way) // 2])
    return Fixture("pillar", Box(np.array([0.02, 0.02, 0.3])), make_pose(tool[:3, 3]))


def test_the_honest_plan(failures, document, problem):
    assert failures(document) == ()
    assert failures(document, problem) == ()


def test_through_a_pillar(failures, document, problem, pillar):
    mentions(failures(replace(document, problem=with_fixture(problem, pillar))), "pillar")


def test_segments_are_not_contact_free_by_their_own_word(failures, document, plan):
    said = with_segments(plan, lambda s: replace(s, contact_free=False))
    mentions(
        failures(replace(document, plan=said)), "transit: a segment of this kind touches nothing"
    )


def test_a_sweep_through_a_pillar_with_an_engine_that_sees_none(
    failures, document, problem, plan, pillar
):
    def swept(segment):
        if segment.kind is not SegmentKind.TRANSIT:
            return segment
        return replace(segment, kind=SegmentKind.SWEEP, contact_free=False)

    blind = {**document.recipe, "backend": {"name": "mujoco", "arm_meets_fixtures": False}}
    forged = replace(
        document,
        problem=with_fixture(problem, pillar),
        plan=with_segments(plan, swept),
        recipe=blind,
    )
    mentions(failures(forged), "contact: robot - pillar")


def test_a_board_that_was_taken_away(failures, document, problem, pillar):
    mentions(failures(document, with_fixture(problem, pillar)), "pillar")


def test_an_immovable_that_is_said_to_be_movable(failures, document, problem):
    guarded = with_object(problem, "blocker", mobility=Mobility.IMMOVABLE)
    mentions(failures(document, guarded), "'blocker': not movable")


def test_masses_of_a_tenth(failures, document, problem):
    mentions(failures(document, with_object(problem, "target", mass=3.0)), "target")


def test_an_object_that_stands_a_little_elsewhere(failures, document, problem):
    poses = np.array(problem.initial.object_poses)
    poses[problem.scene.index("post"), 0] += 0.005
    moved = replace(problem, initial=SceneState(problem.initial.joint_positions, poses))
    assert failures(document, moved) == ()


@pytest.mark.parametrize("key", ["region", "counts", "causes"])
def test_what_nobody_can_check_is_not_in_the_file(document, key):
    data = json.loads(plan_text(document))
    with pytest.raises(InputError, match=key):
        read_plan_text(json.dumps({**data, key: {}}), "plan.json")


def test_a_problem_that_the_plan_does_not_speak_of(document, problem):
    renamed = with_object(problem, "blocker", name="somebody")
    with pytest.raises(InputError, match=r"no objects \['blocker'\] in the problem"):
        in_problem(document, renamed)
