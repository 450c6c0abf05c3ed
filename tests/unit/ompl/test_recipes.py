"""A recipe names one of them instead of rrt_connect."""

from pathlib import Path

from mamo_core.compose import compose
from mamo_core.plugins import discover
from mamo_core.problems import load_problem
from mamo_core.recipe_sets import chosen_recipe
from mamo_core.types.solution import SolutionStatus

ROOT = Path(__file__).parents[3]


def test_m4m_solves_with_it():
    problem = load_problem(ROOT / "problems/shelf_5_easy_seed1.yaml")
    recipe = chosen_recipe("m4m", settings=("arm_planner=ompl_rrt_connect", "search.nearby={}"))
    planner = compose(recipe, problem, discover())
    assert type(planner.context.arm_planner).__name__ == "OmplArmPlanner"
    solution = planner.solve(seed=0)
    assert solution.status is SolutionStatus.SOLVED, solution.reason
    assert planner.verify(solution.plan).ok
