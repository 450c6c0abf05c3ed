"""Priority, goals, likeness and the database of pushes, one by one."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mamo_planners.search.features import Features, features_of
from mamo_planners.search.goals import Failure, GoalMemory, GoalPenalties
from mamo_planners.search.likeness import alike
from mamo_planners.search.priority import PriorityModel, log_density, log_survival
from mamo_planners.search.push_database import PushDatabase
from mamo_planners.search.vertices import Aim, Vertex

from mamo_core.testing.fakes import StraightPush, StraightRetrieval
from mamo_core.testing.scenes import one_blocker, two_blockers
from mamo_core.types.geometry import make_pose
from mamo_core.types.scene import SceneState

THESIS = PriorityModel(0.3403101839, 45.0750087432, 1.5634743875, 32.1092604858)


def region_of(problem):
    retrieval = StraightRetrieval(problem)
    found = retrieval.plan(problem.initial, np.random.default_rng(0), ignore_movables=True)
    return retrieval.swept_region(problem.initial, found.motion)


def moved(problem, **shifts):
    poses = np.array(problem.initial.object_poses)
    for name, (dx, dy) in shifts.items():
        poses[problem.scene.index(name), :2] += (dx, dy)
    return SceneState(problem.initial.joint_positions, poses)


def test_features():
    problem = two_blockers().problem
    region = region_of(problem)
    both = features_of(problem, problem.initial, region)
    one = features_of(problem, moved(problem, a=(0.0, 0.3)), region)
    none = features_of(problem, moved(problem, a=(0.0, 0.3), b=(0.0, -0.3)), region)
    assert (both.count, one.count, none.count) == (2, 1, 0)
    assert both.occupied > one.occupied > none.occupied == 0.0
    assert all(0.0 < effort <= 0.2 * 0.5 for effort in both.efforts)


@settings(max_examples=50, deadline=None)
@given(
    share=st.floats(0.0, 0.5),
    efforts=st.lists(st.floats(0.0, 0.3), max_size=4),
    extra=st.floats(0.0, 0.3),
)
def test_another_object_never_raises_the_survival(share, efforts, extra):
    before = Features(share, len(efforts), tuple(efforts))
    after = Features(share, len(efforts) + 1, (*efforts, extra))
    assert log_survival(THESIS, after) < log_survival(THESIS, before)


def test_another_object_may_raise_the_thesis_density():
    one, two = Features(0.02, 1, (0.01,)), Features(0.02, 2, (0.01, 0.001))
    assert log_density(THESIS, two) > log_density(THESIS, one)
    assert log_survival(THESIS, two) < log_survival(THESIS, one)


def test_poses_count_as_the_same_within_a_centimetre_and_five_degrees():
    scene = one_blocker().problem.scene
    poses = one_blocker().problem.initial.object_poses
    target, a = scene.target_index, scene.index("a")

    def turned(place, degrees, shift=0.0):
        new = np.array(poses)
        x, y, z = new[place, :3]
        new[place] = make_pose([x + shift, y, z], np.radians(degrees))
        return alike(scene, poses, new)

    assert turned(a, 4.0, 0.009).all()
    assert not turned(a, 6.0)[a]
    assert not turned(a, 0.0, 0.011)[a]
    assert turned(target, 90.0).all()  # it is a cylinder
    flipped = np.array(poses)
    flipped[:, 3:] *= -1.0
    assert alike(scene, poses, flipped).all()


class TestGoals:
    memory = GoalMemory(radius=0.005, weight=6.0, shared=0.5)

    def vertex(self, *aims, expansions=1):
        stand = type("Stand", (), {"state": one_blocker().problem.initial})()
        return Vertex(0, stand, (), aims=list(aims), expansions=expansions)

    def ask(self, vertex, memory=memory, failures=()):
        return GoalPenalties(one_blocker().problem.scene, memory).of(vertex, list(failures))

    def test_nothing_is_known_at_first(self):
        assert self.ask(self.vertex(expansions=0)) == {}

    def test_a_failed_goal_is_forbidden_and_its_surroundings_cost(self):
        goal = np.array([0.25, 0.1])
        found = self.ask(self.vertex(Aim("a", goal, 0)))["a"]
        assert [p.cost for p in found] == [float("inf"), 3.0, 1.0, 2.0]
        assert [p.radius for p in found] == pytest.approx([0.005, 0.01, 0.02, 0.03])

    def test_without_anything_new_there_is_nothing_to_ask(self):
        vertex = self.vertex(Aim("a", np.array([0.25, 0.1]), 0))
        assert self.ask(vertex) is not None
        assert self.ask(vertex) is None

    def test_waiting_and_reached_goals_are_hallucinated_last(self):
        failed, waiting, reached = (np.array([0.25, y]) for y in (0.1, 0.2, 0.3))
        vertex = self.vertex(
            Aim("a", failed, 0), Aim("a", waiting, 1), Aim("a", reached, 0, reached=True)
        )
        plain = replace(self.memory, weight=0.0)
        assert len(self.ask(vertex, plain)["a"]) == 1
        assert len(self.ask(vertex, plain)["a"]) == 3
        assert self.ask(vertex, plain) is None

    def test_failures_elsewhere_count_where_the_object_stands_the_same(self):
        start = one_blocker().problem.initial.object_poses[0, :2]
        here = Failure("a", start + 0.005, np.array([0.3, 0.2]))
        away = Failure("a", start + 0.05, np.array([0.3, 0.3]))
        found = self.ask(self.vertex(expansions=0), failures=[here, away])["a"]
        assert sum(p.cost for p in found) == pytest.approx(3.0)
        assert all(np.allclose(p.position, [0.3, 0.2]) for p in found)


class TestDatabase:
    problem = two_blockers().problem
    path = np.array([[0.15, 0.02], [0.15, 0.1]])

    def database(self, clear=True):
        asked = []
        database = PushDatabase(self.problem, lambda *what: asked.append(what) or clear)
        request = type("Request", (), {"object_name": "a", "path": self.path})()
        push = StraightPush(self.problem)
        (action,) = push.propose(self.problem.initial, request, np.random.default_rng(0), None)
        database.add(action, self.path, self.problem.initial, moved(self.problem, a=(0.0, 0.08)))
        return database, asked

    def test_the_same_state_is_a_hit(self):
        database, asked = self.database()
        stored = database.find("a", self.path, self.problem.initial)
        assert stored is not None
        assert asked == []
        after = database.outcome(stored, self.problem.initial)
        np.testing.assert_allclose(after.object_poses[0, 1], 0.10)

    def test_other_paths_and_objects_are_not(self):
        database, _ = self.database()
        other = self.path + np.array([[0.0, 0.0], [0.02, 0.0]])
        assert database.find("a", other, self.problem.initial) is None
        assert database.find("b", self.path, self.problem.initial) is None

    def test_what_was_pushed_must_stand_where_it_stood(self):
        database, _ = self.database()
        assert database.find("a", self.path, moved(self.problem, a=(0.015, 0.0))) is None
        assert database.find("a", self.path, moved(self.problem, a=(0.005, 0.0))) is not None

    def test_what_was_not_touched_may_be_elsewhere_out_of_the_way(self):
        state = moved(self.problem, b=(0.2, -0.2))
        database, asked = self.database()
        stored = database.find("a", self.path, state)
        assert stored is not None
        assert [names for _, _, names in asked] == [["b"]]
        after = database.outcome(stored, state)
        np.testing.assert_allclose(after.object_poses[1, :2], state.object_poses[1, :2])
        assert self.database(clear=False)[0].find("a", self.path, state) is None

    def test_not_where_the_pushed_object_goes(self):
        database, _ = self.database()
        assert database.find("a", self.path, moved(self.problem, b=(-0.15, 0.15))) is None

    def test_all_pushes_are_kept(self):
        database, _ = self.database()
        first = database.find("a", self.path, self.problem.initial)
        elsewhere = moved(self.problem, a=(0.004, 0.0))
        database.add(first.action, self.path, elsewhere, moved(self.problem, a=(0.004, 0.3)))
        assert database.find("a", self.path, self.problem.initial) is first
