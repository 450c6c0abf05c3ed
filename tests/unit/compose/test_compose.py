"""Composing: options and capabilities are checked before anything is built."""

import pickle
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import Field

from mamo_core.choices import BUILD_ORDER, choose
from mamo_core.compose import build_parts, compose
from mamo_core.config import load_text
from mamo_core.errors import InputError, PluginError
from mamo_core.hookspecs import HOOK_OF_ROLE, Component, Options
from mamo_core.plugins import Registered, Registry
from mamo_core.recipe_sets import apply_sets
from mamo_core.recipes import load_recipe
from mamo_core.types.geometry import Box, make_pose
from mamo_core.types.problem import ConstraintSpec, Problem
from mamo_core.types.scene import Mobility, Scene, SceneObject, SceneState, Workspace
from mamo_core.types.solution import Budget, Solution, SolutionStatus, Statistics

TEXT = """\
schema_version: 1
name: r
backend: toy
kinematics: toy
collision: toy
arm_planner: toy
retrieval: toy
mapf: toy
actions: [push, pick]
search: {name: toy, depth: 2}
"""


class SearchOptions(Options):
    depth: int = Field(default=1, ge=1)


class Search:
    def __init__(self, context, options):
        self.context, self.options = context, options

    def solve(self, budget, rng, progress):
        progress("searching")
        info = {"draw": rng.random(), "budget": budget}
        return Solution(SolutionStatus.BUDGET_EXHAUSTED, None, Statistics(), info=info)


class World:
    """A registry of toys that remember in which order they were built."""

    def __init__(self):
        self.built = []
        self.components = {(role, "toy"): self.part(role) for role in HOOK_OF_ROLE}
        self.components["action", "push"] = self.part("action", name="push")
        self.components["action", "pick"] = self.part("action", name="pick")
        self.components["search", "toy"] = Component("toy", self.search, SearchOptions)

    def part(self, role, name="toy", **keywords):
        def build(context, options):
            self.built.append((role, name, context))
            return f"{role} {name}"

        return Component(name, build, **keywords)

    def search(self, context, options):
        self.built.append(("search", "toy", context))
        return Search(context, options)

    @property
    def registry(self):
        return Registry(tuple(Registered(r, "p", c) for (r, _), c in self.components.items()))

    def compose(self, *settings, problem=None):
        return compose(recipe(*settings), problem or PROBLEM, self.registry, ROBOT)

    def complaint(self, *settings, problem=None, error=InputError):
        with pytest.raises(error) as caught:
            self.compose(*settings, problem=problem)
        return str(caught.value)


def recipe(*settings):
    return load_recipe(apply_sets(load_text(TEXT, "r.yaml"), settings))


TOY = (ConstraintSpec("toy"),)


def make_problem(constraints=TOY, joints=(0.0, 0.0)):
    scene = Scene(
        robot="toy",
        T_world_base=make_pose([0, 0, 0]),
        fixtures=(),
        objects=(SceneObject("t", Box([0.1, 0.1, 0.1]), Mobility.TARGET, 1.0, 0.5),),
        workspace=Workspace([0, 0, 0], [1, 1, 1]),
    )
    state = SceneState(np.array(joints), np.array([make_pose([0.5, 0.5, 0.05])]))
    return Problem("p", scene, state, np.array(joints), (), constraints)


ROBOT = SimpleNamespace(
    name="toy", dof=2, joint_names=("a", "b"), lower=np.array([-1.0, -1.0]), upper=np.ones(2)
)
PROBLEM = make_problem()


def test_everything_is_built_in_the_documented_order():
    world = World()
    planner = world.compose()
    assert [role for role, _, _ in world.built] == [
        *[role for role in BUILD_ORDER if role not in ("accept_in", "action", "search")],
        "action",
        "action",
        "search",
    ]
    context = planner.context
    assert context.constraints == ("constraint toy",)
    assert context.retrieval == "retrieval toy"
    assert context.actions == (("push", "action push"), ("pick", "action pick"))
    assert planner.search.options.depth == 2
    assert planner.search.context is context


def test_a_part_sees_what_was_built_before_it():
    world = World()
    world.compose()
    seen = {role: context for role, _, context in world.built}
    assert seen["backend"].constraints == ("constraint toy",)
    assert seen["backend"].verifier is None
    assert seen["kinematics"].verifier is not None
    assert seen["kinematics"].collision is None
    assert seen["arm_planner"].collision == "collision toy"
    assert seen["action"].actions == ()


def test_the_search_can_build_the_backend_for_another_problem():
    """With constraints for that problem and the same robot, and nothing else is built."""
    world = World()
    planner = world.compose()
    del world.built[:]
    other = replace(make_problem(), name="smaller")
    assert planner.context.part("engine_for")(other) == "backend toy"
    (constraint, _, _), (backend, _, seen) = world.built
    assert (constraint, backend) == ("constraint", "backend")
    assert seen.problem is other
    assert seen.robot is ROBOT
    assert seen.constraints == ("constraint toy",)
    assert planner.context.problem is PROBLEM


def test_engines_for_other_problems_have_the_options_of_the_recipe():
    world, asked = World(), []

    def build(context, options):
        asked.append((context.problem.name, options.depth))
        return "backend toy"

    world.components["backend", "toy"] = Component("toy", build, SearchOptions)
    planner = world.compose("backend={name: toy, depth: 3}")
    planner.context.engine_for(replace(PROBLEM, name="smaller"))
    assert asked == [("p", 3), ("smaller", 3)]


def test_an_engine_with_other_options():
    world, asked = World(), []

    def build(context, options):
        asked.append((options.depth, options.wide))
        return "backend toy"

    class TwoOptions(SearchOptions):
        wide: bool = False

    world.components["backend", "toy"] = Component("toy", build, TwoOptions)
    planner = world.compose("backend={name: toy, depth: 3}")
    planner.context.engine_for(PROBLEM, {"wide": True})
    assert asked == [(3, False), (3, True)]
    wrong = "changed options of backend 'toy': unknown key 'deep'; .*valid: depth, wide"
    with pytest.raises(InputError, match=wrong):
        planner.context.engine_for(PROBLEM, {"deep": 3})


def test_without_a_backend_there_is_none_for_other_problems_either():
    world = World()
    context = build_parts(
        choose(recipe(), PROBLEM, world.registry, ("kinematics",)), PROBLEM, ROBOT
    )
    with pytest.raises(InputError, match="a part 'backend' is needed, and the recipe gives none"):
        context.engine_for(PROBLEM)


def test_what_parts_are_built_from_can_be_sent_to_another_process():
    """Engines in processes of their own take it along."""
    world = World()
    world.compose()
    backend = next(context for role, _, context in world.built if role == "backend")
    assert backend.engine_for is None
    assert pickle.loads(pickle.dumps(backend)).problem.name == PROBLEM.name


def test_solve_passes_budget_seed_and_progress():
    planner = World().compose()
    told = []
    first = planner.solve(3.0, 7, told.append)
    assert first.info["draw"] == np.random.default_rng(7).random()
    assert isinstance(first.info["budget"], Budget)
    assert first.info["budget"].seconds == 3.0
    assert told == ["searching"]
    assert planner.solve(seed=8).info["draw"] != first.info["draw"]


def test_a_subset_of_roles():
    world = World()
    choices = choose(recipe(), PROBLEM, world.registry, ("collision", "retrieval"))
    context = build_parts(choices, PROBLEM, ROBOT)
    assert [role for role, _, _ in world.built] == ["collision", "retrieval"]
    assert context.backend is None


@pytest.mark.parametrize(
    ("setting", "expected"),
    [
        ("backend=tay", "--set backend: unknown backend 'tay'; did you mean 'toy'? (valid: toy)"),
        ("search.depth=0", "--set search.depth: search.depth: 0, expected a number of at least 1"),
        (
            "search.dept=3",
            "--set search.dept: unknown key 'search.dept'; did you mean 'depth'? (valid: depth)",
        ),
        ("actions.push.x=1", "--set actions.push.x: unknown key 'actions.0.x' (valid: none)"),
    ],
)
def test_mistakes_are_found_before_anything_is_built(setting, expected):
    world = World()
    assert world.complaint(setting) == expected
    assert world.built == []


def test_mistakes_in_the_file_have_a_place(tmp_path):
    text = TEXT.replace("depth: 2", "depth: two").replace("collision: toy", "collision: tyo")
    with pytest.raises(InputError) as caught:
        compose(load_recipe(load_text(text, "r.yaml")), PROBLEM, World().registry, ROBOT)
    assert str(caught.value).startswith("r.yaml:5:12: unknown collision 'tyo'; did you mean 'toy'?")
    text = text.replace("tyo", "toy")
    with pytest.raises(InputError) as caught:
        compose(load_recipe(load_text(text, "r.yaml")), PROBLEM, World().registry, ROBOT)
    assert str(caught.value) == "r.yaml:10:28: search.depth: 'two', expected a whole number"


def test_missing_capability_names_both_parts():
    world = World()
    needs = {"backend": frozenset({"batch", "exact_continuation", "contact_forces"})}
    world.components["action", "push"] = world.part("action", "push", requires=needs)
    world.components["backend", "toy"] = world.part("backend", provides=frozenset({"batch"}))
    assert world.complaint() == (
        "r.yaml:9:11: action 'push' needs contact_forces, exact_continuation from the backend, "
        "but backend 'toy' provides batch"
    )
    assert world.built == []


class DemandingOptions(SearchOptions):
    """Deep ones need more."""

    def needs(self):
        return {"backend": frozenset({"memory"} if self.depth > 1 else ())}


def test_values_of_options_may_need_capabilities():
    world = World()
    world.components["search", "toy"] = Component("toy", world.search, DemandingOptions)
    world.compose("search.depth=1")
    del world.built[:]
    assert world.complaint() == (
        "r.yaml:10:16: search 'toy' needs memory from the backend, but backend 'toy' "
        "provides nothing"
    )
    assert world.built == []


def test_values_ask_nothing_of_parts_in_other_roles():
    """Engines of accept_in are none of the search's."""
    world = World()
    world.components["search", "toy"] = Component("toy", world.search, DemandingOptions)
    world.components["backend", "toy"] = world.part("backend", provides=frozenset({"memory"}))
    world.components["backend", "other"] = world.part("backend", "other")
    world.compose("accept_in=[other]")


def test_engines_for_other_problems_have_the_limits_of_these():
    world, asked = World(), []

    def build(context, options):
        asked.append(options.depth)
        return "constraint toy"

    world.components["constraint", "toy"] = Component("toy", build, DemandingOptions)
    planner = world.compose()
    planner.context.engine_for(make_problem((ConstraintSpec("toy", {"depth": 1}),)))
    assert asked == [1, 1]
    strict = make_problem((ConstraintSpec("toy", {"depth": 5}),))
    with pytest.raises(InputError, match="constraint 'toy' needs memory from the backend"):
        planner.context.engine_for(strict)


def test_every_part_of_a_role_must_have_the_capability():
    world = World()
    world.components["search", "toy"] = world.part(
        "search", requires={"action": frozenset({"undo"})}
    )
    world.components["action", "push"] = world.part("action", "push", provides=frozenset({"undo"}))
    assert "but action 'pick' provides nothing" in world.complaint("search=toy")


def test_missing_part():
    world = World()
    needs = {"mapf": frozenset()}
    world.components["action", "push"] = world.part("action", "push", requires=needs)
    assert world.complaint("mapf=null") == "r.yaml:9:11: action 'push' needs a part 'mapf'"
    world.compose()


def test_missing_package():
    world = World()

    def build(context, options):
        raise ModuleNotFoundError("No module named 'pybullet'")

    world.components["backend", "toy"] = Component("toy", build)
    expected = "backend 'toy' cannot be built: No module named 'pybullet'"
    assert world.complaint(error=PluginError) == expected


def test_constraints_of_the_problem():
    unknown = make_problem((ConstraintSpec("toy"), ConstraintSpec("tyo")))
    assert World().complaint(problem=unknown) == (
        "problem 'p': constraints: unknown constraint 'tyo'; did you mean 'toy'? (valid: toy)"
    )
    wrong = make_problem((ConstraintSpec("toy", {"limit": 3}),))
    assert World().complaint(problem=wrong) == (
        "problem 'p': constraints: toy: unknown key 'limit' (valid: none)"
    )


def test_joints_of_the_problem():
    assert World().complaint(problem=make_problem(joints=(0.0,))) == (
        "problem 'p': initial configuration has 1 joints, robot 'toy' has 2"
    )
    assert World().complaint(problem=make_problem(joints=(0.0, 1.5))) == (
        "problem 'p': initial configuration: b is 1.5, expected -1 to 1"
    )


def test_unknown_robot():
    with pytest.raises(InputError, match="'toy'"):
        compose(recipe(), PROBLEM, World().registry)
