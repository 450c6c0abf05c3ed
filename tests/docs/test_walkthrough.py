"""The page that shows how a plan comes about says what the script measures and draws."""

import re
from pathlib import Path

from mamo_core.problems import load_problem

DOCS = Path(__file__).parents[2] / "docs"
LARGEST = 300_000
"""Bytes of a picture."""


def test_figures_and_pictures_are_those_of_the_script(tmp_path):
    import walkthrough
    from walkthrough_parts.measures import told
    from walkthrough_parts.pictures import draw_all
    from walkthrough_parts.walk import walk

    page = (DOCS / "how_a_plan_comes_about.md").read_text(encoding="utf-8")
    way = walk(load_problem(walkthrough.PROBLEM))
    (figures,) = re.findall(r"^```text\n(.*?)\n```", page, re.MULTILINE | re.DOTALL)
    assert told(way) == figures
    draw_all(way, tmp_path)
    shown = re.findall(r"\]\(images/(\S+)\)", page)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(shown)
    for name in shown:
        assert (tmp_path / name).read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
        assert (DOCS / "images" / name).stat().st_size < LARGEST


def test_watching_changes_nothing():
    """The plan is the one that ``mamo plan`` finds."""
    import numpy as np
    from walkthrough_parts.walk import RECIPE, walk

    from mamo_core.compose import compose
    from mamo_core.plugins import discover
    from mamo_core.recipe_sets import chosen_recipe

    problem = load_problem(DOCS.parent / "problems" / "shelf_5_easy_seed1.yaml")
    seen, alone = (
        walk(problem).plan,
        compose(chosen_recipe(RECIPE), problem, discover()).solve(60.0).plan,
    )
    assert seen.actions
    for ours, theirs in zip(seen.motions, alone.motions, strict=True):
        for one, other in zip(ours.segments, theirs.segments, strict=True):
            assert np.array_equal(one.trajectory.positions, other.trajectory.positions)
