"""Where the arm may end, for both tasks."""

from dataclasses import replace

import numpy as np
import pytest
from mamo_planners.reaching.goals import Goals

from mamo_core.testing.gantry import UprightGantry
from mamo_core.testing.scenes import OPENING, clear_scene, one_blocker, reach_past, walled_in
from mamo_core.types.geometry import make_pose
from mamo_core.types.problem import Grasp, Task


def rng():
    return np.random.default_rng(0)


def goals_of(problem, parts):
    return Goals(problem, parts.arm, parts.kinematics, parts.collision, rng())


def flat_goals(reaching, problem, **changes):
    return goals_of(problem, reaching(problem, **changes).parts)


def grasp(approach=0.1, opening=OPENING, yaw=0.0, z=-0.01):
    return Grasp(make_pose([0.0, 0.0, z], yaw), approach, opening)


class Reluctant(UprightGantry):
    """Finds something only where it looks for many solutions; all questions are kept."""

    def __init__(self, least):
        super().__init__()
        self.least, self.asked = least, []

    def inverse(self, T_world_tool, rng, *, count, near=None):
        self.asked.append(count)
        found = super().inverse(T_world_tool, rng, count=count, near=near)
        return found if count >= self.least else found[:0]


@pytest.fixture(scope="module")
def reach():
    return reach_past(clear_scene()).problem


def test_a_reach_ends_at_the_pre_grasp(reaching, reach):
    goals = flat_goals(reaching, reach)
    (goal,) = goals.known
    assert goal.configuration == pytest.approx([0.35, 0.0, 0.05, 0.0])
    assert goal.candidate is None
    assert goals.tools[0] == pytest.approx(reach.pregrasps[0])
    assert goals.opening == OPENING


def test_movables_are_no_reason_against_a_goal_and_immovables_are(reaching):
    problem = reach_past(walled_in()).problem

    def standing(name):
        poses = np.array(problem.initial.object_poses)
        poses[problem.scene.index(name), :2] = (0.35, 0.03)
        return replace(problem, initial=replace(problem.initial, object_poses=poses))

    assert len(flat_goals(reaching, standing("a")).known) == 1
    assert flat_goals(reaching, standing("w")).known == ()


def test_no_goal_no_tools(reaching, reach):
    far = replace(reach, grasps=(grasp(approach=9.0),))
    goals = flat_goals(reaching, far)
    assert goals.known == ()
    assert goals.tools.shape == (0, 4, 4)


def test_the_hand_opens_as_the_first_usable_grasp_wants_it(reaching, reach):
    several = replace(
        reach,
        grasps=(
            grasp(approach=9.0, opening=0.09),  # out of reach
            grasp(opening=0.07),
            grasp(opening=0.08, yaw=0.5),
            grasp(opening=0.07, yaw=-0.5),
        ),
    )
    goals = flat_goals(reaching, several)
    assert goals.opening == 0.07
    assert [goal.configuration[3] for goal in goals.known] == pytest.approx([0.0, -0.5])


@pytest.mark.parametrize(
    ("least", "asked", "found"), [(1, [8], 1), (9, [8, 160], 1), (161, [8, 160], 0)]
)
def test_it_looks_harder_before_it_says_there_are_none(reaching, reach, least, asked, found):
    kinematics = Reluctant(least)
    goals = flat_goals(reaching, reach, kinematics=kinematics)
    assert len(goals.known) == found
    assert kinematics.asked == asked


def test_near_is_computed_anew_and_falls_back_on_a_known_one(reaching, reach):
    two = replace(reach, grasps=(grasp(), grasp(yaw=np.pi / 2)))
    parts = reaching(two).parts
    goals = goals_of(two, parts)
    first, second = goals.known
    near = goals.near(second.configuration + 0.1, rng())
    assert near is not second
    assert near.configuration == pytest.approx(second.configuration)
    parts.kinematics._upper = np.full(4, -5.0)  # nothing is within its limits any more
    assert goals.near(first.configuration, rng()) is first
    assert goals.drawn(rng()) in goals.known


def test_drawn_ones_are_all_over(reaching, reach):
    two = replace(reach, grasps=(grasp(), grasp(yaw=np.pi / 2)))
    goals, draw = flat_goals(reaching, two), rng()
    yaws = {round(float(goals.drawn(draw).configuration[3]), 3) for _ in range(20)}
    assert yaws == {0.0, 1.571}


def test_worlds(reaching):
    problem = reach_past(one_blocker()).problem
    goals = flat_goals(reaching, problem)
    at_blocker, at_target = (np.array([x, 0.0, 0.05, 0.0]) for x in (0.25, 0.45))
    assert goals.without_movables().free(at_blocker)[0]
    assert not goals.without_movables().free(at_target)[0]
    assert not goals.with_everything(problem.initial).free(at_blocker)[0]


@pytest.fixture(scope="module")
def retrieval(problem, parts):
    return goals_of(problem, parts)


def test_a_retrieval_ends_where_a_candidate_begins(problem, parts, retrieval):
    assert problem.task is Task.RETRIEVE
    assert retrieval.known
    for goal, T in zip(retrieval.known, retrieval.tools, strict=True):
        assert np.array_equal(goal.configuration, goal.candidate.reach[0])
        assert goal.candidate.grasp.opening == retrieval.opening
        assert parts.kinematics.forward(goal.configuration) == pytest.approx(T)


def test_the_goal_of_a_retrieval_is_one_of_its_candidates(retrieval):
    goal = retrieval.known[-1]
    assert retrieval.near(goal.configuration + 1e-3, rng()) is goal
    assert retrieval.drawn(rng()) in retrieval.known
