"""Bad input: exit code 2, a message that says what is wrong and where, and no traceback."""

import gzip
import json
import signal
from pathlib import Path

import pytest

from mamo_core.cli.main import main
from mamo_core.problems import generate_shelf, save_problems

SMALL = Path(__file__).parents[2] / "golden" / "small_shelf.yaml"
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
        ((*PLAN, "--graph", "graph.png"), "--graph graph.png: expected a name that ends in .svg"),
        (
            (*PLAN, "--graph", "graph.svg"),
            "--graph: search 'toy' keeps no graph of rearrangements (those that do: best_first, de",
        ),
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
        (("problem", "generate", "fridge", "-o", "x.json"), "No such command 'fridge'"),
        (("problem", "generate", "tabletop", "--movables", "-1", "-o", "x.json"), "--movables"),
        (("problem", "generate", "refrigerator", "--immovables", "0", "-o", "x.json"), "--immov"),
        (("problem", "generate", "tabletop", "-o", "x.txt"), "x.txt: unknown ending (valid: .js"),
        (
            ("view", "none.json"),
            "nothing to show: give one or more of --png, --still, --mp4, --gif",
        ),
        (("view", "none.json", "--mp4", "a.mp4"), "none.json: no such file"),
        (("view", "none.npz", "--gif", "a.gif", "--backends", "toy_engine"), "--backends: a rec"),
        (("view", "none.npz", "--still", "a.png", "--size", "640"), "--size 640: expected WIDTHxH"),
        (("view", "none.npz", "--gif", "a.gif", "--size", "9000x64"), "each 64 to 4096"),
        (("view", "none.npz", "--mp4", "a.mp4", "--size", "101x80"), "expected even numbers for -"),
        (("view", "none.npz", "--mp4", "a.mp4", "--fps", "0"), "--fps"),
        (("view", "none.npz", "--mp4", "a.mp4", "--speed", "0"), "--speed"),
        (
            ("view", "none.npz", "--mp4", "a.mp4", "--renderer", "mujocco"),
            "--renderer: unknown renderer 'mujocco'; did you mean 'mujoco'?",
        ),
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


@pytest.fixture
def a_set(run):
    """``set.jsonl.gz`` beside the problem: three shelves."""
    problems = [generate_shelf(movables=n, seed=1) for n in (0, 1, 2)]
    save_problems(problems, "set.jsonl.gz")
    return [problem.name for problem in problems]


def test_unknown_id_of_a_set(run, a_set):
    fails(
        run("plan", "set.jsonl.gz#shelf_4_seed1"),
        "set.jsonl.gz: no problem 'shelf_4_seed1'; did you mean 'shelf_",
        f"(valid: {', '.join(a_set)})",
    )


def test_a_set_needs_an_id(run, a_set):
    fails(run("plan", "set.jsonl.gz"), "holds 3 problems, pick one with '#id'", a_set[2])


@pytest.mark.parametrize("kept", [0.1, 0.5, 0.99])
def test_truncated_gzip(run, a_set, kept):
    with open("set.jsonl.gz", "rb") as file:
        data = file.read()
    with open("set.jsonl.gz", "wb") as file:
        file.write(data[: int(kept * len(data))])
    fails(run("plan", f"set.jsonl.gz#{a_set[0]}"), "set.jsonl.gz: the gzip file is damaged")


def rewrite_set(change):
    """Change the lines of ``set.jsonl.gz``."""
    lines = gzip.decompress(Path("set.jsonl.gz").read_bytes()).decode().splitlines()
    change(lines)
    Path("set.jsonl.gz").write_bytes(gzip.compress("\n".join(lines).encode()))


def test_a_line_cut_short(run, a_set):
    def cut(lines):
        lines[2] = lines[2][:-40]

    rewrite_set(cut)
    fails(run("plan", f"set.jsonl.gz#{a_set[0]}"), "set.jsonl.gz:3:", "not valid YAML or JSON")


def test_mistakes_in_a_set_name_the_line(run, a_set):
    def break_second(lines):
        document = json.loads(lines[1])
        document["objects"][0]["mass"] = -1
        lines[1] = json.dumps(document)

    rewrite_set(break_second)
    fails(
        run("plan", f"set.jsonl.gz#{a_set[1]}"),
        "set.jsonl.gz:2:",
        "objects.0.mass: -1, expected",
    )


@pytest.mark.parametrize("kept", [0.0, 0.3, 0.95])
def test_truncated_document(run, kept):
    save_problems([generate_shelf(movables=1, seed=1)], "shelf.json")
    text = Path("shelf.json").read_text()
    write("shelf.json", text[: int(kept * len(text))])
    fails(run("plan", "shelf.json"), "error: shelf.json:")


def test_not_text(run):
    Path("noise.yaml").write_bytes(bytes(range(256)))
    fails(run("plan", "noise.yaml"), "noise.yaml: byte 128 is not UTF-8 text")


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("target: t", "target: *t", ("problem.yaml:8:9: alias '*t': aliases are not allowed",)),
        ("target: t", "target: !t t", ("problem.yaml:8:9: ", "tag")),
        ("friction: 0.5", "friction: .inf", ("friction: inf, expected a finite number",)),
        ("friction: 0.5", "friction: 0", ("friction: 0, expected", "problem.yaml:6:")),
        ("[0.06, 0.06, 0.2]", "[0.06, 0.06]", ("problem.yaml:6:", "box")),
        ("name: o1", "name: t", ("problem.yaml:7:", "name 't' is already that of objects.0")),
        ("[0.5, 0.2, 0.1]", "[0.5, 0.2, 0.4]", ("problem.yaml:6:", "above the floor")),
        ("[0.5, 0.2, 0.1]", "[3.5, 0.2, 0.1]", ("problem.yaml:6:", "outside the workspace")),
        ("schema_version: 1", "schema_version: 7", ("problem.yaml:1:", "schema_version: 7")),
    ],
)
def test_more_problems(run, old, new, expected):
    edit("problem.yaml", old, new)
    fails(run(*PLAN), *expected)


def test_unknown_constraint(run):
    with open("problem.yaml", "a") as file:
        file.write("constraints: [{name: tild}]\n")
    fails(run(*PLAN), "unknown constraint 'tild'; did you mean 'tilt'?")


def test_unknown_option_of_a_constraint(run):
    with open("problem.yaml", "a") as file:
        file.write("constraints: [{name: tilt, options: {limit: 3}}]\n")
    fails(run(*PLAN), "tilt", "unknown key", "'limit_deg'")


@pytest.fixture
def real_run(tmp_path, monkeypatch, capsys):
    """Runs a command with the real robot, planner and engine."""
    monkeypatch.chdir(tmp_path)
    handler = signal.getsignal(signal.SIGINT)

    def run(*arguments):
        with pytest.raises(SystemExit) as caught:
            main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        return caught.value.code, out, err

    yield run
    signal.signal(signal.SIGINT, handler)


def unreachable(old, new):
    text = SMALL.read_text()
    assert old in text
    write("far.yaml", text.replace(old, new, 1))


def test_target_out_of_reach(real_run):
    unreachable("position: [0.0, 0.0, 0.0]", "position: [-2.0, 0.0, 0.0]")
    code, out, err = real_run("plan", "far.yaml", "-o", "plan.json", "--json")
    assert code == 3, err
    document = json.loads(out)
    assert (document["status"], document["verified"]) == ("no_plan_proved", None)
    assert document["reason"] == ("no way to retrieve target even without movables: out_of_reach")
    assert document["causes"]["target/retrieval/out_of_reach"] > 0
    assert "Traceback" not in err
    assert not Path("plan.json").exists()


GRASP = "[{position: [-0.1, 0, 0], approach: 0.1, opening: 0.07}]"


def unknown_robot(real_run, grasps):
    unreachable("name: pr2_right_arm", "name: pr2_rigth_arm")
    edit("far.yaml", "grasps: auto", f"grasps: {grasps}")
    code, out, err = real_run("plan", "far.yaml")
    assert (code, out) == (2, "")
    assert "Traceback" not in err
    assert "did you mean 'pr2_right_arm'?" in err
    return err


def test_unknown_robot(real_run):
    assert "far.yaml:4:9: " in unknown_robot(real_run, "auto")


def test_unknown_robot_with_given_grasps(real_run):
    assert "far.yaml:4:9: " in unknown_robot(real_run, GRASP)


def test_target_behind_an_immovable(real_run):
    unreachable("mobility: movable", "mobility: immovable")
    code, out, err = real_run("plan", "far.yaml")
    assert code == 3, err
    assert "small: budget_exhausted" in out
    assert "no way to retrieve target even without movables: " in out
    assert "Traceback" not in err


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ((), "Missing argument 'KIND'"),
        (("action",), "Missing argument 'NAME'"),
        (("actoin", "own"), "mamo plugins new: unknown KIND 'actoin'; did you mean 'action'?"),
        (("robot", "own"), "(valid: action, backend, constraint, mapf, search)"),
        (("action", "Own"), "mamo plugins new: NAME 'Own', expected small letters, digits and"),
        (("action", "1st"), "NAME '1st', expected"),
        (("action", "my-own"), "NAME 'my-own', expected"),
        (("action", "_own"), "NAME '_own', expected"),
        (("action", "../own"), "NAME '../own', expected"),
        (("action", "push"), "NAME 'push': plugin 'planners' has the action of this name"),
        (
            ("action", "core"),
            "NAME 'core': the Python package 'mamo_core' is installed; choose another",
        ),
        (("action", "rearrangement"), "its class 'RearrangementAction' would hide one of mamo's"),
        (("action", "own", "-o", "problem.yaml"), "problem.yaml: is a file, expected a new or"),
        (("action", "own", "-o", "."), ".: the folder is not empty, expected a new or an empty"),
        (("action", "own", "-o", "no/own"), "no/own: no such folder 'no'"),
    ],
)
def test_a_plugin_that_cannot_be_written(run, arguments, expected):
    before = sorted(Path().iterdir())
    fails(run("plugins", "new", *arguments), expected)
    assert sorted(Path().iterdir()) == before
