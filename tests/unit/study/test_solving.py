"""What workers do before and besides solving."""

import pytest

import mamo_core.study.solving as solving
from mamo_core.hookspecs import Component
from mamo_core.problems import problem_from_document
from mamo_core.recipes import find_recipe, load_recipe
from mamo_core.types.problem import Task


@pytest.mark.parametrize(
    ("tasks", "first"),
    [({"retrieve"}, "shelf"), ({"reach"}, "tabletop"), ({"retrieve", "reach"}, "shelf")],
)
def test_the_first_problem_is_one_the_search_plans_for(monkeypatch, tasks, first):
    class Registry:
        def component(self, role, name, place):
            assert (role, name) == ("search", "greedy")
            return Component(name, lambda context, options: None, tasks=frozenset(tasks))

    monkeypatch.setattr(solving, "_registry", Registry)
    problem = solving._first_problem(load_recipe(find_recipe("m4m")))
    assert problem.name.startswith(first)
    assert problem.task in tasks


def test_a_reach_is_generated_and_classified():
    document = solving.generate_workspace("refrigerator", 3, 2, 1)
    problem = problem_from_document(document, "here")
    assert (problem.name, problem.task) == ("refrigerator_3_2_seed1", Task.REACH)
    assert solving.classify(document) in ("none", "easy", "medium", "hard")
