"""What README and docs show must work: Python runs, recipes compose; so do all shipped recipes."""

import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from mamo_core.choices import choose
from mamo_core.compose import compose
from mamo_core.config import load_text
from mamo_core.errors import InputError
from mamo_core.plugins import discover
from mamo_core.problems import load_problem
from mamo_core.recipes import find_recipe, load_recipe, shipped_recipes
from mamo_core.types.problem import Task

ROOT = Path(__file__).parents[2]
PAGES = [
    *sorted(ROOT.glob("*.md")),
    *(path for part in ("docs", "mamo_core") for path in sorted((ROOT / part).rglob("*.md"))),
]
PROBLEM = ROOT / "problems" / "shelf_5_easy_seed1.yaml"
REACH = ROOT / "problems" / "tabletop_6_6_seed1.yaml"
REACHING = [
    *("spamp", "spamp_thesis", "naive", "naive_dd", "subg", "subg_dd", "phase1", "selsim", "ss2"),
    *("kpiece_k1", "kpiece_k2", "kpiece_k3", "rrt"),
]


def blocks(language):
    """(page and line, text) of every fenced block in a language."""
    found = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for match in re.finditer(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
            line = text[: match.start()].count("\n") + 1
            found.append(pytest.param(match.group(1), id=f"{page.name}:{line}"))
    return found


def prose(page):
    """A page without its blocks of code."""
    return re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)


def links():
    """(page, target) of every link within the repository, to files and to headings."""
    return [
        pytest.param(page, target, id=f"{page.relative_to(ROOT)}-{target}")
        for page in PAGES
        for target in re.findall(r"\]\(([^):]+)\)", prose(page))
    ]


def anchors(page):
    """What GitHub makes of the headings."""
    headings = re.findall(r"^#+ (.+)$", prose(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.fixture(scope="module")
def registry():
    return discover()


@pytest.fixture(scope="module")
def problem():
    return load_problem(PROBLEM)


@pytest.mark.parametrize("code", blocks("python"))
def test_python_runs(code):
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "verified: False" not in done.stdout


@pytest.mark.parametrize("text", blocks("yaml"))
def test_recipes_in_the_docs_compose(text, problem, registry):
    assert compose(load_recipe(load_text(text, "docs")), problem, registry).search is not None


@pytest.mark.parametrize("text", blocks("yaml problem"))
def test_problems_in_the_docs_are_valid(text, tmp_path):
    (tmp_path / "problem.yaml").write_text(text, encoding="utf-8")
    assert load_problem(tmp_path / "problem.yaml").scene.objects


@pytest.mark.parametrize("name", shipped_recipes())
def test_shipped_recipes_compose(name, problem, registry):
    assert compose(load_recipe(find_recipe(name)), problem, registry).search is not None


@pytest.mark.parametrize(("page", "target"), links())
def test_links_lead_somewhere(page, target):
    name, _, anchor = target.partition("#")
    file = page.parent / name if name else page
    assert file.exists()
    assert not anchor or anchor in anchors(file)


@pytest.mark.parametrize("name", REACHING)
def test_recipes_that_reach_compose_for_a_reach(name, registry):
    problem = load_problem(REACH)
    assert problem.task is Task.REACH
    assert compose(load_recipe(find_recipe(name)), problem, registry).search is not None


def test_all_others_are_refused_for_a_reach(registry):
    problem = load_problem(REACH)
    for name in sorted(set(shipped_recipes()) - set(REACHING)):
        with pytest.raises(InputError, match="does not plan for the task 'reach'"):
            choose(load_recipe(find_recipe(name)), problem, registry)


def test_there_is_something_to_test():
    assert min(len(blocks("python")), len(blocks("yaml"))) >= 2
    assert blocks("yaml problem")


def test_every_yaml_block_is_of_a_kind_that_is_tested():
    """``yaml study`` is read where studies are tested, or run by a tutorial."""
    kinds = {line for page in PAGES for line in re.findall(r"^```(yaml.*)", page.read_text(), re.M)}
    assert kinds == {"yaml", "yaml problem", "yaml study"}


def test_what_the_page_on_the_thesis_names_is_there():
    text = (ROOT / "docs" / "relation_to_the_thesis.md").read_text(encoding="utf-8")
    modules = set(re.findall(r"`(mamo_\w+(?:\.\w+)+)`", text))
    assert len(modules) > 30
    assert [name for name in modules if find_spec(name) is None] == []
    for file in re.findall(r"`((?:studies|benchmarks)/\S+)`", text):
        assert (ROOT / file).is_file(), file
    assert [name for name in shipped_recipes() if f"`{name}`" not in text] == []
