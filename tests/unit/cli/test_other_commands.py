"""The commands around planning."""

import importlib
import json
import sys

import pytest

from mamo_core.classify import make_classifier
from mamo_core.plugins import discover, make_registry
from mamo_core.problems import load_problem, problem_ids
from mamo_core.recipes import find_recipe, load_recipe


def test_help_lists_all_commands(run):
    done = run("--help")
    assert done.code == 0
    for command in ("plan", "verify", "problem", "plugins", "schema", "warmup"):
        assert f"\n  {command} " in done.out


def test_version(run):
    done = run("--version")
    assert done.code == 0
    assert done.out.startswith("mamo ")


def test_plugins_list(run):
    done = run("plugins", "list")
    assert done.code == 0
    rows = [line.split() for line in done.out.splitlines()]
    assert ["backend", "toy_engine", "toys", "falls", "[never]"] in rows
    assert any(row[:3] == ["constraint", "tilt", "constraints"] for row in rows)


def test_plugins_list_as_json(run):
    document = json.loads(run("plugins", "list", "--json").out)
    assert document["schema_version"] == 1
    assert {
        "role": "backend",
        "name": "toy_engine",
        "plugin": "toys",
        "summary": "falls [never]",
        "provides": [],
    } in document["components"]
    assert all(problem["plugin"] != "toys" for problem in document["problems"])


def test_broken_plugin_is_listed(run, tmp_path):
    (tmp_path / "site" / "toy_plugin.py").write_text("import nothing_like_it\n")
    done = run("plugins", "list", "--json")
    assert done.code == 0
    problems = {p["plugin"]: p["message"] for p in json.loads(done.out)["problems"]}
    assert problems["toys"].startswith("toy_plugin cannot be imported: ModuleNotFoundError")
    assert "plugin 'toys' is disabled" in run("plugins", "list").err


@pytest.mark.parametrize("kind", ["recipe", "problem", "plan"])
def test_schema(run, kind):
    schema = json.loads(run("schema", kind).out)
    assert schema["type"] == "object"
    assert "schema_version" in schema["properties"]


def test_schema_allows_short_parts(run):
    part = json.loads(run("schema", "recipe").out)["$defs"]["Part"]
    assert [option["type"] for option in part["anyOf"]] == ["string", "object"]


def test_warmup_runs_what_plugins_bring(run, monkeypatch):
    # Under a name that no other process knows, so that it is run here, where we can look.
    toys = make_registry([("by_hand", lambda: importlib.import_module("toy_plugin"))])
    monkeypatch.setattr("mamo_core.plugins.discover", lambda: toys)  # ours would compile for long
    done = run("warmup")
    assert done.code == 0
    assert done.out.startswith("ready after ")
    assert "plugin by_hand is ready" in done.err
    assert sys.modules["toy_plugin"].WARMED == ["toy"]


def test_problem_show(run):
    done = run("problem", "show", "problem.yaml", "--png", "p.png")
    assert done.code == 0
    lines = [" ".join(line.split()) for line in done.out.splitlines()]
    assert lines[0] == "two_things (pr2_right_arm)"
    assert "t target box 0.060 x 0.060 x 0.200 0.500, 0.200, 0.100 0.400 0.500" in lines
    with open("p.png") as file:
        assert file.read() == "two_things False"


def test_problem_show_as_json(run):
    document = json.loads(run("problem", "show", "problem.yaml", "--json").out)
    assert document["command"] == "problem show"
    assert document["problem"]["target"] == "t"


def test_problem_import(run):
    done = run("problem", "import", "problem.yaml", "-o", "set.jsonl.gz")
    assert (done.code, done.out) == (0, "set.jsonl.gz: 1 problem\n")
    assert run("problem", "show", "set.jsonl.gz#two_things").code == 0


def test_a_set_needs_a_file_for_sets(run):
    arguments = ("problem", "generate", "shelf", "--level", "easy", "--movables", 5, "--count", 2)
    done = run(*arguments, "-o", "x.json")
    assert done.code == 2
    assert done.err == "error: x.json: 2 problems need a file that ends in .jsonl or .jsonl.gz\n"


@pytest.fixture
def everything_in_reach(monkeypatch):
    import mamo_core.cli.generating as generating

    monkeypatch.setattr(generating, "make_classifier", lambda *arguments: lambda problem: 1)


@pytest.mark.usefixtures("everything_in_reach")
@pytest.mark.parametrize(
    ("arguments", "ids"),
    [
        (("tabletop", "--seed", 4), ["tabletop_6_6_seed4"]),
        (("refrigerator", "--count", 2), ["refrigerator_3_2_seed0", "refrigerator_3_2_seed1"]),
        (("tabletop", "--movables", 8, "--immovables", 2), ["tabletop_8_2_seed0"]),
        (("shelf",), ["shelf_10_seed0"]),
        (("shelf", "--level", "easy", "--movables", 5), ["shelf_5_easy_seed0"]),
    ],
)
def test_problem_generate(run, arguments, ids):
    done = run("problem", "generate", *arguments, "-o", "made.jsonl")
    noun = "problem" if len(ids) == 1 else "problems"
    assert (done.code, done.out) == (0, f"made.jsonl: {len(ids)} {noun}\n")
    assert problem_ids("made.jsonl") == ids


def test_classifier_counts_the_movables_in_the_way(run):
    classify = make_classifier(load_recipe(find_recipe("toy.yaml")), discover())
    assert classify(load_problem("problem.yaml")) == 1
    with open("problem.yaml") as file:
        text = file.read()
    with open("left.yaml", "w") as file:
        file.write(text.replace("[0.3, 0.2, 0.1]", "[0.3, -0.2, 0.1]"))
    assert classify(load_problem("left.yaml")) == 0
    with open("walled.yaml", "w") as file:
        file.write(text.replace("[0.5, 0.2, 0.1]", "[0.5, -0.2, 0.1]"))
    assert classify(load_problem("walled.yaml")) is None
