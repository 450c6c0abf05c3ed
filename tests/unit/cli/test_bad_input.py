"""Bad input: exit code 2, a message that says what is wrong and where, and no traceback."""

import pytest

PLAN = ("plan", "problem.yaml", "--planner", "toy.yaml")


def write(name, text):
    with open(name, "w") as file:
        file.write(text)


def edit(name, old, new):
    with open(name) as file:
        text = file.read()
    assert old in text
    write(name, text.replace(old, new))


def fails(outcome, *expected, code=2):
    assert outcome.code == code, outcome
    assert outcome.out == ""
    assert "Traceback" not in outcome.err
    for text in expected:
        assert text in outcome.err


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ((), "Usage: mamo"),
        (("plan",), "Missing argument"),
        (("plann",), "No such command 'plann'"),
        ((*PLAN, "--budgets", "3"), "No such option"),
        ((*PLAN, "--budget", "soon"), "--budget"),
        ((*PLAN, "--budget", "-1"), "--budget"),
        ((*PLAN, "--budget", "nan"), "--budget"),
        ((*PLAN, "--seed", "-1"), "--seed"),
        ((*PLAN, "-o", "nowhere/plan.json"), "nowhere/plan.json: no such folder 'nowhere'"),
        ((*PLAN, "--png", "."), "is a folder, expected a file"),
        ((*PLAN, "--set", "search"), "--set search: expected KEY=VALUE"),
        ((*PLAN, "--set", "search.outcom=x"), "--set search.outcom: unknown key 'search.outcom'"),
        (
            (*PLAN, "--set", "search.outcome=x"),
            "--set search.outcome: search.outcome: 'x', expected",
        ),
        ((*PLAN, "--backend", "toy_engin"), "--backend: unknown backend 'toy_engin'; did you mean"),
        (
            ("plan", "problem.yaml", "--planner", "m4n"),
            "unknown planner 'm4n'; did you mean 'm4m'?",
        ),
        (("plan", "none.yaml"), "none.yaml"),
        (("plan", "problem.yaml#3", "--planner", "toy.yaml"), "'3'"),
        (("verify", "none.json"), "none.json: no such file"),
        (("verify", "problem.yaml"), "problem.yaml:"),
        (("problem", "import", "problem.yaml", "-o", "x.txt"), "x.txt: unknown ending"),
        (("problem", "show", "none.yaml"), "none.yaml"),
        (("problem", "generate", "shelf", "--level", "hrd", "--movables", "3", "-o", "x"), "hrd"),
        (("schema", "recip"), "recip"),
    ],
)
def test_arguments(run, arguments, expected):
    outcome = run(*arguments)
    assert outcome.code == 2
    assert "Traceback" not in outcome.err
    assert expected in outcome.err + outcome.out


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("search: toy", "serch: toy", "toy.yaml:9:1: unknown key 'serch'; did you mean 'search'?"),
        ("kinematics: toy", "kinematics: toi", "toy.yaml:4:13: unknown kinematics 'toi'; did you"),
        ("search: toy", "search: [toy]", "toy.yaml:9:9: search: ['toy'], expected a name"),
        ("search: toy", "search: toy\nsearch: toy", "toy.yaml:10:1: duplicate key 'search'"),
        ("search: toy", "search: *toy", "toy.yaml:9:9: alias '*toy': aliases are not allowed"),
        ("search: toy", "search: {name: to", "toy.yaml:10:1: not valid YAML or JSON"),
        (
            "backend: toy_engine",
            "backend: {name: toy_engine, breaks: 1}",
            "toy.yaml:3:37: backend.breaks: 1, expected true or false",
        ),
    ],
)
def test_recipes(run, old, new, expected):
    edit("toy.yaml", old, new)
    fails(run(*PLAN), expected)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("target: t", "targt: t", ("problem.yaml:8:1: unknown key 'targt'", "'target'")),
        ("target: t", "target: o2", ("problem.yaml:8:9: ", "'o2'", "(valid: o1, t)")),
        ("mass: 0.4", "mass: .nan", ("problem.yaml:6:", "mass: nan, expected a finite number")),
        ("[0.06, 0.06, 0.2]", "[0.06, -1, 0.2]", ("problem.yaml:6:", "box.1: -1, expected")),
        ("mass: 0.4", "mass: heavy", ("mass: 'heavy', expected a number",)),
        ("target: t", "target: t\ntarget: t", ("problem.yaml:9:1: duplicate key 'target'",)),
        ("[0.3, 0.2, 0.1]", "[0.46, 0.2, 0.1]", ("problem.yaml:7:", "'t' and 'o1' overlap")),
        ("target: t", "target: &a t", ("problem.yaml:8:9: anchor '&a': anchors are not",)),
        ("joints: [0, ", "joints: [2, ", ("j0 is 2, expected -1 to 1",)),
        ("opening: 0.07}", "opening: 0.0", ("problem.yaml:", "not valid YAML or JSON")),
    ],
)
def test_problems(run, old, new, expected):
    edit("problem.yaml", old, new)
    fails(run(*PLAN), *expected)


def test_truncated_plan(run):
    run(*PLAN, "-o", "plan.json")
    with open("plan.json") as file:
        text = file.read()
    write("plan.json", text[:-20])
    fails(run("verify", "plan.json"), "error: plan.json:", "not valid YAML or JSON")


def test_broken_plugin_is_named_and_exits_5_where_it_is_needed(run, tmp_path):
    with open(tmp_path / "site" / "toy_plugin.py", "w") as file:
        file.write("import nothing_like_it\n")
    outcome = run(*PLAN)
    fails(outcome, "unknown backend 'toy_engine'", code=5)
    assert "plugin 'toys' is disabled: toy_plugin cannot be imported" in outcome.err
