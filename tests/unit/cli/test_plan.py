"""``mamo plan`` and ``mamo verify``: results, exit codes, files."""

import json
import os
from pathlib import Path

import pytest

PLAN = ("plan", "problem.yaml", "--planner", "toy.yaml")


def test_solved(run, tmp_path):
    done = run(*PLAN, "-o", "plan.json", "--png", "plan.png")
    assert done.code == 0
    assert "two_things: solved" in done.out
    for row in (
        "planner  toy_planner",
        "push o1, retrieve",
        "verification  passed",
        "mapf",
        "0.25",
    ):
        assert " ".join(row.split()) in " ".join(done.out.split())
    assert "searching with [solved]" in done.err
    assert sorted(os.listdir()) == ["plan.json", "plan.png", "problem.yaml", "toy.yaml"]
    assert (tmp_path / "work" / "plan.png").read_text() == "two_things True"


def test_json_is_the_only_thing_on_stdout(run):
    done = run(*PLAN, "--json", "--seed", 5, "-o", "plan.json")
    document = json.loads(done.out)
    assert document.pop("cpu_s") >= 0.0
    assert document == {
        "schema_version": 1,
        "command": "plan",
        "problem": "two_things",
        "planner": "toy_planner",
        "seed": 5,
        "status": "solved",
        "verified": True,
        "failures": [],
        "reason": "",
        "actions": [{"kind": "push", "object": "o1"}],
        "parts": {"mapf": 0.25},
        "counts": {"rollouts": 4},
        "causes": {"o1/push/stalled": 7, "o1/push/no_ik": 3},
        "explanation": None,
        "plan_file": "plan.json",
        "picture": None,
        "margin": {"1 mm": 0.9},
    }


def test_the_same_seed_gives_the_same_file(run, tmp_path):
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        assert run(*PLAN, "--seed", seed, "-o", name).code == 0
    a, b, c = ((tmp_path / "work" / name).read_bytes() for name in "abc")
    assert a == b
    assert a != c


@pytest.mark.parametrize(
    ("outcome", "status"), [("exhausted", "budget_exhausted"), ("proved", "no_plan_proved")]
)
def test_no_plan_says_why(run, outcome, status):
    done = run(*PLAN, "--set", f"search.outcome={outcome}", "-o", "plan.json", "--png", "p.png")
    assert done.code == 3
    assert f"two_things: {status}" in done.out
    assert "the target is walled in" in done.out
    assert (
        "why: o1 stands in the way, and no action moved it: "
        "with push the arm stalls (7 of 7 simulated)" in done.out
    )
    causes = [line.split()[:4] for line in done.out.splitlines()[-2:]]
    assert causes == [["o1", "push", "7", "stalled"], ["o1", "push", "3", "no_ik"]]
    assert "no plan: looking for what stands in the way" in done.err
    assert not os.path.exists("plan.json")
    assert os.path.exists("p.png")


def test_no_plan_as_json(run):
    done = run(*PLAN, "--set", "search.outcome=proved", "--json")
    assert done.code == 3
    document = json.loads(done.out)
    assert document["causes"] == {"o1/push/stalled": 7, "o1/push/no_ik": 3}
    assert document["explanation"] == {
        "headline": "o1 stands in the way, and no action moved it: "
        "with push the arm stalls (7 of 7 simulated)",
        "obstruction": "action",
        "subjects": ["o1"],
        "causes": ["stalled"],
        "involved": [],
        "details": [
            {
                "subject": "o1",
                "action": "push",
                "cause": "stalled",
                "times": 7,
                "words": "the arm stalls",
                "involved": {},
            },
            {
                "subject": "o1",
                "action": "push",
                "cause": "no_ik",
                "times": 3,
                "words": "no arm configuration brings the hand behind it",
                "involved": {},
            },
        ],
    }


def test_a_plan_that_does_not_pass(run):
    done = run(*PLAN, "--set", "backend=toy_wreck", "-o", "plan.json")
    assert done.code == 4
    assert "two_things: verification_failed" in done.out
    assert "tilt: o1 at 1.000 s" in done.out
    assert "why:" not in done.out
    assert [line.split()[:4] for line in done.out.splitlines()[-1:]] == [
        ["o1", "push", "3", "no_ik"]
    ]
    assert not os.path.exists("plan.json")


def test_options_of_the_recipe_are_not_the_verifiers(run):
    """Neither to pass, nor to fail."""
    done = run(*PLAN, "--set", "backend.breaks=true", "-o", "plan.json")
    assert done.code == 0
    assert run("verify", "plan.json").code == 0


def test_internal_error_is_one_line(run, monkeypatch):
    done = run(*PLAN, "--set", "search.outcome=crash")
    assert done.code == 1
    assert done.out == ""
    assert done.err.splitlines()[-1] == (
        "internal error: RuntimeError: toys break (for details set MAMO_TRACEBACK=1)"
    )
    assert "Traceback" not in done.err
    monkeypatch.setenv("MAMO_TRACEBACK", "1")
    assert "Traceback" in run(*PLAN, "--set", "search.outcome=crash").err


def test_interrupted(run):
    done = run(*PLAN, "--set", "search.outcome=interrupt", "-o", "plan.json")
    assert done.code == 130
    assert done.err.splitlines()[-1] == "interrupted"
    assert not os.path.exists("plan.json")


OWN = "in the world of the plan file itself"


def test_verify(run):
    run(*PLAN, "-o", "plan.json")
    done = run("verify", "plan.json")
    assert done.code == 0
    told, *unasked = done.out.splitlines()
    assert told == f"plan.json: verified with toy_engine, {OWN}"
    assert [line.split(":")[0] for line in unasked] == ["  not asked"] * 2
    done = run("verify", "plan.json", "--json")
    document = json.loads(done.out)
    assert len(document.pop("unasked")) == 2
    assert document == {
        "schema_version": 1,
        "command": "verify",
        "plan_file": "plan.json",
        "problem": "two_things",
        "backend": "toy_engine",
        "world": "the plan file itself",
        "verified": True,
        "failures": [],
    }


def edit_plan(change):
    with open("plan.json") as file:
        data = json.load(file)
    change(data)
    with open("plan.json", "w") as file:
        json.dump(data, file)


def test_verify_fails(run):
    run(*PLAN, "-o", "plan.json")
    edit_plan(lambda data: data["recipe"].update(backend="toy_wreck"))
    done = run("verify", "plan.json")
    assert done.code == 4
    assert done.out.startswith(f"plan.json: FAILED with toy_wreck, {OWN}\n  tilt: o1 at 1.000 s\n")
    assert run("verify", "plan.json", "--backend", "toy_engine").code == 0


def test_verify_warns_of_other_versions(run):
    run(*PLAN, "-o", "plan.json")
    edit_plan(lambda data: data["versions"].update(numpy="0.1"))
    done = run("verify", "plan.json")
    assert done.code == 0
    assert "warning: the plan was made with numpy 0.1, installed is " in done.err


def test_verify_names_the_recipe_of_the_plan(run):
    run(*PLAN, "-o", "plan.json")
    edit_plan(lambda data: data["recipe"].pop("search"))
    done = run("verify", "plan.json")
    assert done.code == 2
    assert done.err == "error: plan.json: recipe: missing key 'search'\n"


def test_verify_in_a_world_of_the_users(run):
    run(*PLAN, "-o", "plan.json")
    text = Path("problem.yaml").read_text()
    Path("mine.yaml").write_text(text.replace("two_things", "mine"))
    done = run("verify", "plan.json", "--problem", "mine.yaml")
    assert done.code == 0
    assert done.out.startswith("plan.json: verified with toy_engine, in the world of mine.yaml\n")
    document = json.loads(run("verify", "plan.json", "--problem", "mine.yaml", "--json").out)
    assert (document["problem"], document["world"]) == ("mine", "mine.yaml")


def test_verify_in_a_world_without_what_the_plan_moves(run):
    run(*PLAN, "-o", "plan.json")
    text = Path("problem.yaml").read_text()
    Path("mine.yaml").write_text(text.replace("name: o1", "name: o2"))
    done = run("verify", "plan.json", "--problem", "mine.yaml")
    assert done.code == 2
    assert done.out == ""
    assert done.err.endswith(
        "error: problem 'two_things' does not fit the plan: "
        "no objects ['o1'] in the problem (valid: ['t', 'o2'])\n"
    )
